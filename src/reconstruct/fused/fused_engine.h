#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "decode/phase_decoder.h"
#include "reconstruct/fused/fused_band.h"
#include "reconstruct/fused/fused_stages.h"
#include "reconstruct/fused/sinusoid_rows.h"

namespace slipstream {

/// Memory of the fused pass, reused from scan to scan.
struct FusedMemory {
  std::vector<FusedScratch> scratch;   ///< one per band of rows
  std::vector<SinusoidLimits> limits;  ///< one per entry of FusedStages::bands
};

/// Resizes the requested outputs; `doubtful`: the maps include fringe_order_doubt.
void prepare(const Outputs& outputs, Size size, bool doubtful);

/// Throws Error unless there are `count` frames of the camera's size.
void require_frames(const FrameViews& frames, int count, Size camera);

/// Frames to cloud in one pass over the pixels: no intermediate image, vectors of floats, bands of
/// rows shared among threads, no allocation once outputs and memory have been used. Thread-safe if
/// each thread has its own output and memory.
struct FusedEngine {
  /// Returns nullopt, with `why_not`, if fused_stages does. `corrections` are added to the phases.
  static std::optional<FusedEngine> make(const EngineSetup& setup,
                                         const PhaseCorrections& corrections,
                                         std::string* why_not = nullptr);

  /// `coarse`: coordinate of each pixel, right to half a period, NaN where unknown; required if
  /// unwraps_by_picture, else not allowed. Throws Error otherwise, and if the frames are not
  /// quantised or their number or size is wrong.
  void operator()(const FrameViews& frames, const Outputs& output, FusedMemory& memory,
                  const Image<float>* coarse = nullptr) const;

  /// Whether `coarse` is required.
  [[nodiscard]] bool wants_coarse() const { return stages->coarse_given; }

  /// Limits of each band for these frames and outputs.
  void find_limits(const FrameViews& frames, const Outputs& output,
                   std::vector<SinusoidLimits>& limits) const;

  std::shared_ptr<const FusedStages> stages;
  ReconstructSettings settings;
};

}  // namespace slipstream
