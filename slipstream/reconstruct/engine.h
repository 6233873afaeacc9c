#pragma once

#include <memory>
#include <string>

#include "slipstream/geometry/scan.h"
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
  Engine(Engine&& other) noexcept = default;
  Engine& operator=(Engine other) noexcept;

  [[nodiscard]] const EngineSetup& setup() const;

  /// Frames with exposures merged, and with what a frame holds at once taken apart, in memory that
  /// lasts until the next call; other frames as they are. All calls below do so themselves.
  [[nodiscard]] const FrameViews& merged(const FrameViews& frames);

  /// Makes what is wanted of a scan, by the engine chosen or the next that can: GPU, fused pass,
  /// reference engine. Of a window over more than a cycle, pixels are rejected whose frames differ
  /// by more than noise and even motion explain; then a cloud is cleaned. Returns how many points
  /// cleaning took, by reason. Throws Error if size or number of the frames is wrong.
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
  /// The points of the cloud alone, not cleaned, in the same order whatever the threads. Only the
  /// fused pass needs no cloud for them, and not of merged frames nor in motion.
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

  /// What really reconstructs such frames: "fused", "gpu" until it fails in any copy, or the
  /// reference engine's methods for their phases, "lut", "equation", "closed-form".
  [[nodiscard]] std::string backend_for(const FrameViews& frames);
  /// Why the engine asked for does not compute, and what does, in one line; empty where it does.
  [[nodiscard]] std::string fallback_reason() const;

 private:
  void compute(const FrameViews& frames, const Outputs& outputs, const Image<float>* coarse);
  void compute_by_picture(const FrameViews& frames, const Outputs& outputs);
  void leave_out_moved(const FrameViews& frames, const Outputs& outputs);

  struct Tables;
  struct Memory;

  std::shared_ptr<Tables> tables_;
  std::shared_ptr<Memory> memory_;  ///< its own
};

/// The cloud of a scan, by an engine made for it alone. Throws Error where the scan has no scanner
/// or does not fit it.
Cloud reconstruct(const Scan& scan, const ReconstructSettings& settings = {});

/// An engine's setup for that scan: its scanner, completed by what the scan says, its sequence and
/// the settings. Throws Error where the scan has no scanner, does not fit it, or has a cue that
/// needs an ambient light unknown to the scanner.
EngineSetup setup_for(const Scan& scan, const ReconstructSettings& settings = {});

/// What the frames of a scan say about its light, with or without a scanner.
struct PictureReport {
  Image<Validity> validity{};  ///< too_dark, saturated, else valid
  double modulation = 0;       ///< median of the valid pixels, grey levels of 255; 0 without any
};

/// By the maps of these frames, which are merged where there are several exposures: Engine::merged.
PictureReport picture_report(const FrameViews& frames, const Maps& maps,
                             const ReconstructSettings& settings);

/// Projector coordinates of pixels that are lit, not saturated and confirmed by their neighbours,
/// NaN elsewhere; with or without a scanner.
Image<double> measured_coordinates(Engine& engine, const FrameViews& frames);

}  // namespace slipstream
