#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "slipstream/check/fit.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/frames/frame_views.h"

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

  /// What does not look as it should in a few pixels.
  struct Suspicion {
    bool residual = false, bands = false, seam = false, darkened = false;

    [[nodiscard]] bool any() const { return residual || bands || seam || darkened; }
    /// What both raise.
    [[nodiscard]] Suspicion of(const Suspicion& other) const {
      return {residual && other.residual, bands && other.bands, seam && other.seam,
              darkened && other.darkened};
    }
    friend bool operator==(const Suspicion&, const Suspicion&) = default;
  };

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
  double harmless_residual_ = 0;    ///< likewise
  std::vector<double> right_sums_;  ///< of each frame, when last all was right
  std::vector<Finding> findings_;   ///< of the last whole check
  Suspicion suspected_;             ///< that led to it
  Clock::time_point checked_{};     ///< when that was; the epoch before the first
};

}  // namespace slipstream
