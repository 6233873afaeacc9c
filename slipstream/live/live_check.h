#pragma once

#include <bitset>
#include <chrono>
#include <optional>
#include <vector>

#include "slipstream/check/fit.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// Whether the frames of a live scan still fit their patterns, the scanner and each other. The
/// first ones are checked as any scan is. Of later ones a few pixels are looked at, cheap enough
/// for every cycle; what they raise a suspicion of is checked whole. One thread uses it.
class LiveCheck {
 public:
  /// Without a scanner less can be told: see check_frames.
  LiveCheck(const Sequence& sequence, const std::optional<Scanner>& scanner, Size camera,
            const CheckSettings& settings = {});

  /// What is amiss with these frames, which are in pattern order and of the camera's size. Nothing
  /// is allocated where nothing is.
  std::vector<Finding> look(const FrameViews& window);

 private:
  using Clock = std::chrono::steady_clock;

  /// What does not look as it should in a few pixels: residual, bands, seam, brightness.
  using Suspicion = std::bitset<4>;

  Suspicion suspicion(const FrameViews& window);
  /// Whether a frame has lost much of its light since the last that was right.
  [[nodiscard]] bool darkened() const;

  Sequence sequence_;
  std::optional<Scanner> scanner_;
  CheckSettings settings_;
  FrameModel model_;
  FrameOrder order_;
  FrameJudge judge_;
  ScanSamples samples_;
  Fit fit_;
  Suspicion harmless_;              ///< raised, but the whole check found nothing
  double harmless_residual_ = 0;    ///< with a margin, of the frames that raised that
  std::vector<double> right_sums_;  ///< of each frame, when last all was right
  std::vector<Finding> findings_;   ///< of the last whole check
  Suspicion suspected_;             ///< that led to it
  Clock::time_point checked_{};     ///< when that was; the epoch before the first
};

}  // namespace slipstream
