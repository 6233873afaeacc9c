#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/maps.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/reconstruct/outputs.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

/// Frames to cloud and maps, for one scanner and one sequence: the one way there is. Tables are
/// built once and memory is reused, so that from the second call on nothing is allocated where the
/// same outputs are handed in. Phases are corrected for the scanner's response where it is known,
/// and clouds are cleaned as the settings say: by default, and not at all by CleanSettings::none().
/// A scanner without geometry (see has_geometry) gives maps alone; all else throws Error.
///
/// One thread uses it at a time. A copy shares the tables and has memory of its own: one for each
/// thread.
class Engine {
 public:
  /// Throws Error as require_reconstructible.
  explicit Engine(const EngineSetup& setup);
  Engine(const Scanner& scanner, const Sequence& sequence,
         const ReconstructSettings& settings = {});
  Engine(const Engine& other);
  Engine(Engine&& other) noexcept;
  Engine& operator=(Engine other) noexcept;
  ~Engine();

  [[nodiscard]] const EngineSetup& setup() const;

  /// The frames of several exposures merged, or what frames hold at once taken apart, in memory
  /// that lasts until others are; frames that need neither as they are. What follows does that of
  /// itself.
  [[nodiscard]] const FrameViews& merged(const FrameViews& frames);

  /// Makes what is wanted of a scan, by the engine chosen or the next that can: the GPU, else the
  /// fused pass, else the reference engine. Of a window over more than a cycle, pixels are left out
  /// whose frames differ by what neither noise nor an even motion makes; then a cloud is cleaned.
  /// Returns how many of its points cleaning took, by reason. Throws Error when the frames are not
  /// of the camera's size or not as many as the sequence's.
  ValidityCounts run(const FrameViews& frames, const Outputs& outputs);

  ValidityCounts cloud(const FrameViews& frames, Cloud& cloud) {
    return run(frames, {.cloud = &cloud});
  }
  /// Less is computed and written than for a cloud; nothing is cleaned.
  void depth(const FrameViews& frames, Depth& depth) { run(frames, {.depth = &depth}); }
  /// Depth only, quantised to 16 bits; pixels without a point are 0.
  void depth(const FrameViews& frames, const DepthScale& scale, Image<std::uint16_t>& numbers) {
    run(frames, {.depth16 = &numbers, .scale = scale});
  }
  /// The points of the cloud alone, not cleaned, in the same order whatever the threads. The fused
  /// pass packs points without a cloud between; of merged frames and in motion, and on other
  /// engines, they are packed from a cloud.
  void points(const FrameViews& frames, PackedPoints& points) { run(frames, {.points = &points}); }
  /// Coordinates as each pixel says them, before the neighbours confirm or deny them.
  void maps(const FrameViews& frames, Maps& maps) { run(frames, {.maps = &maps}); }
  /// Both in one pass.
  ValidityCounts cloud_and_maps(const FrameViews& frames, Cloud& cloud, Maps& maps) {
    return run(frames, {.cloud = &cloud, .maps = &maps});
  }

  /// Share of the measured pixels whose phase moves, see MotionMeasurement; 0 where the frames are
  /// no window of more than a cycle.
  [[nodiscard]] double moving_share(const FrameViews& frames) const;

  /// How sure each point of a scan is under noise of the scanner's variance at the pixel's mean
  /// (1.6 where it is not known): sigma of y by Eq. (3.40) or (3.63), and of X, Y, Z through the
  /// derivative of the point. `frames` are those that cloud and maps were made from.
  [[nodiscard]] Uncertainty uncertainty(const Cloud& cloud, const Maps& maps,
                                        const FrameViews& frames);

  /// What really reconstructs such frames: "fused", "gpu", or the methods by which the reference
  /// engine computes their phases, "lut", "equation", "closed-form". Where a GPU has failed, in any
  /// copy, it is "fused" from then on.
  [[nodiscard]] std::string backend_for(const FrameViews& frames);
  /// Why the GPU that was asked for no longer computes, in one line; empty where it does, or where
  /// none was.
  [[nodiscard]] std::string gpu_failure() const;

 private:
  void compute(const FrameViews& frames, const Outputs& outputs);
  void compute_by_picture(const FrameViews& frames, const Outputs& outputs);
  void run_pass(const FrameViews& frames, const Outputs& outputs, const Image<float>* coarse);
  void leave_out_moved(const FrameViews& frames, const Outputs& outputs);

  struct Tables;
  struct Memory;

  std::shared_ptr<Tables> tables_;
  std::unique_ptr<Memory> memory_;
};

/// The cloud of a scan, by an engine made for it alone. Throws Error where the scan has no scanner
/// or does not fit it.
Cloud reconstruct(const Scan& scan, const ReconstructSettings& settings = {});

/// What an engine for that scan is made of: its scanner, completed by what the scan says, its
/// sequence and the settings. Throws Error where the scan has no scanner, does not fit it, or has a
/// cue that cannot be read without an ambient light that the scanner does not know.
EngineSetup setup_for(const Scan& scan, const ReconstructSettings& settings = {});

}  // namespace slipstream
