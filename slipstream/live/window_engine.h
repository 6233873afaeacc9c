#pragma once

#include "slipstream/check/fit.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/reconstruct/engine.h"

namespace slipstream {

/// Whether the frames of a live scan still fit their patterns, the scanner and each other. The
/// first ones are checked as any scan is. Of later ones a few pixels are looked at, cheap enough
/// for every cycle; what they raise a suspicion of is checked whole. One thread uses it.
class LiveCheck {
 public:
  /// Without a scanner less can be told: see check_frames.
  LiveCheck(const Sequence& sequence, const std::optional<Scanner>& scanner, Size camera,
            const CheckSettings& settings = {});

  /// Findings of frames in pattern order, of the camera's size. Without any nothing is allocated.
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

/// Makes, checks and reconstructs windows, in memory that is kept from one to the next.
struct WindowEngine {
  WindowEngine(const EngineSetup& setup, const LiveSettings& settings);

  /// Fills the window's cloud (empty without a scanner) and `motion`; returns what cleaning took.
  ValidityCounts reconstruct(LiveCloud& window);
  /// Whether the window is to be looked at: once in a cycle, when its last pattern has come.
  [[nodiscard]] bool is_due(const LiveCloud& window) const;
  std::vector<Finding> look(const LiveCloud& window);

  /// Of windows that begin with each pattern; one for all where they are in pattern order.
  std::vector<Engine> engines;
  std::optional<Engine> still;  ///< of one cycle, where that is to do while nothing moves
  Engine* used = nullptr;       ///< that of them which made the newest cloud
  FrameViews views;
  std::function<std::vector<Finding>(const FrameViews&)> check;
  std::optional<std::uint64_t> looked;  ///< sequence of the newest frame that was looked at
  std::shared_ptr<Pool<Frame>> frames;  ///< that its windows are made of
};

}  // namespace slipstream
