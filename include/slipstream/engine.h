#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "slipstream/reconstruct_settings.h"
#include "slipstream/scan.h"

namespace slipstream {

/// Converts frames to clouds and maps for one scanner and one sequence; all reconstruction goes
/// through it. Builds its tables once and reuses its memory: from the second call on it does not
/// allocate if it gets the same outputs. Corrects phases for the scanner's response if known, and
/// cleans clouds as the settings say; CleanSettings::none() turns cleaning off. A scanner without
/// geometry (see has_geometry) gives maps only; other outputs throw Error.
///
/// For one thread at a time. Copies share the tables but not the memory: make one per thread.
class Engine {
 public:
  /// Throws Error as require_reconstructible does; as require_valid without geometry.
  explicit Engine(const EngineSetup& setup);
  Engine(const Scanner& scanner, const Sequence& sequence,
         const ReconstructSettings& settings = {});

  Engine(const Engine& other);
  Engine(Engine&& other) noexcept = default;
  Engine& operator=(Engine other) noexcept;

  [[nodiscard]] const EngineSetup& setup() const;

  /// Frames with exposures merged and multiplexed frames separated, in memory that lasts until the
  /// next call; other frames are returned unchanged. All calls below do this themselves.
  [[nodiscard]] const FrameViews& merged(const FrameViews& frames);

  /// Computes the requested outputs with the chosen engine or, failing that, the next in this
  /// order: GPU, fused pass, reference engine. In windows longer than a cycle, rejects pixels whose
  /// frames differ by more than noise and uniform motion explain; then cleans the cloud. Returns
  /// how many points cleaning removed, by reason. Throws Error for a wrong size or frame count.
  ValidityCounts run(const FrameViews& frames, const Outputs& outputs);

  ValidityCounts cloud(const FrameViews& frames, Cloud& cloud) {
    return run(frames, {.cloud = &cloud});
  }

  /// Computes and writes less than a cloud does; not cleaned.
  void depth(const FrameViews& frames, Depth& depth) { run(frames, {.depth = &depth}); }

  /// Depth only, quantised to 16 bits; pixels without a point are 0.
  void depth(const FrameViews& frames, const DepthScale& scale, Image<std::uint16_t>& numbers) {
    run(frames, {.depth16 = &numbers, .scale = scale});
  }

  /// Only the valid points, not cleaned, in an order that does not depend on the number of threads.
  /// Written by the fused pass unless frames are merged or a motion window, else copied.
  void points(const FrameViews& frames, PackedPoints& points) { run(frames, {.points = &points}); }

  /// Coordinates from each pixel alone, not yet confirmed or rejected by its neighbours.
  void maps(const FrameViews& frames, Maps& maps) { run(frames, {.maps = &maps}); }

  /// Both in one pass.
  ValidityCounts cloud_and_maps(const FrameViews& frames, Cloud& cloud, Maps& maps) {
    return run(frames, {.cloud = &cloud, .maps = &maps});
  }

  /// Share of the measured pixels whose phase moves, see MotionMeasurement; 0 for up to one cycle.
  [[nodiscard]] double moving_share(const FrameViews& frames) const;

  /// Standard deviation of each point of a scan under the scanner's noise variance at the pixel's
  /// mean (1.6 if unknown): of y by Eq. (3.40) or (3.63), of X, Y, Z through the derivative of the
  /// point. `frames`: the ones that `cloud` and `maps` were made from.
  [[nodiscard]] Uncertainty uncertainty(const Cloud& cloud, const Maps& maps,
                                        const FrameViews& frames);

  /// Backend used for such frames: "fused", "gpu" until it fails in any copy, or the phase method
  /// of the reference engine: "lut", "equation", "closed-form".
  [[nodiscard]] std::string backend_for(const FrameViews& frames);

  /// Why the chosen or default engine does not take scans such as the newest, and what replaces it,
  /// one line; empty if it does.
  [[nodiscard]] std::string fallback_reason() const;

 private:
  void compute(const FrameViews& frames, const Outputs& outputs, const Image<float>* coarse);
  void compute_by_picture(const FrameViews& frames, const Outputs& outputs);
  void leave_out_moved(const FrameViews& frames, const Outputs& outputs);

  struct Tables;
  struct Memory;

  std::shared_ptr<Tables> tables_;
  std::shared_ptr<Memory> memory_;  ///< not shared by copies
};

/// Setup of an engine for this scan: its scanner, completed from the scan, its sequence, and the
/// settings. Throws Error if the scan has no scanner, does not fit it, or has a cue that needs the
/// ambient light and the scanner does not know it.
EngineSetup setup_for(const Scan& scan, const ReconstructSettings& settings = {});

/// Result of comparing a scan with patterns along the other axis. It reveals only errors across the
/// epipolar line: where the line runs along x, errors of x alone stay hidden.
struct EpipolarCheck {
  double median = 0;         ///< of the points' distances, projector pixels
  double median_length = 0;  ///< of their absolute values
  double median_sigma = 0;   ///< of their standard deviations due to noise
  std::size_t doubted = 0;   ///< points farther off than noise explains

  /// Whether the distances far exceed noise, so that calibration and scan do not match.
  [[nodiscard]] bool contradicts() const;
};

/// Light in the frames of a scan, with or without a scanner.
struct PictureReport {
  Image<Validity> validity{};  ///< `too_dark`, `saturated` or `valid`
  double modulation = 0;       ///< median of the valid pixels, grey levels of 255; 0 without any
};

/// `maps`: of these frames, which must be merged if there are several exposures: Engine::merged.
PictureReport picture_report(const FrameViews& frames, const Maps& maps,
                             const ReconstructSettings& settings);

/// Projector coordinates of pixels that are lit, not saturated and confirmed by their neighbours,
/// NaN elsewhere; with or without a scanner. Throws Error if the frames alone give none.
Image<double> measured_coordinates(Engine& engine, const FrameViews& frames);
/// The same from the engine's maps of these frames.
Image<double> measured_coordinates(Engine& engine, const FrameViews& frames, const Maps& maps);

}  // namespace slipstream
