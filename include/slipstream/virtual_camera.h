#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/frame_source.h"
#include "slipstream/pattern_set.h"
#include "slipstream/scanner.h"
#include "slipstream/scene.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {

class ReelPlayer;
class RenderedReel;

/// Whether bodies that move rest first, for a cycle, where the loop of their motion begins.
enum class FirstRest {
  none,
  once,
  until_rendered,  ///< the cycle is repeated until the loop is rendered
};

/// All frames of a camera while the patterns are shown `cycles` times, as a seamless loop: bodies
/// move back and forth through their position at time 0, or rotate continuously if they only turn
/// and the frames last a full turn to within half a cycle. Each frame has its own noise. Throws
/// Error for less than one cycle, without bits of the camera, and as take_scan.
std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles);

/// Repeats a reel endlessly, and counts its frames as a real camera does. Frames that are not
/// rendered yet come later and do not count as lost.
class VirtualCamera : public FrameSource {
 public:
  /// Frames buffered by a camera with its own pace; beyond these it loses the oldest.
  static constexpr int waiting_frames = 8;

  /// `rate`: Hz; without it, frames arrive as fast as they are requested. Throws Error if the rate
  /// is not positive.
  explicit VirtualCamera(std::shared_ptr<const RenderedReel> reel,
                         std::optional<double> rate = std::nullopt);

  /// Frames of one format, which keep the pattern index of their stamps. Throws Error without
  /// frames, or if their formats differ.
  explicit VirtualCamera(Reel reel, std::optional<double> rate = std::nullopt);

  /// Each frame once.
  explicit VirtualCamera(std::vector<Frame> loop, std::optional<double> rate = std::nullopt);

  ~VirtualCamera() override;

  [[nodiscard]] FrameFormat format() const override;
  [[nodiscard]] bool has_own_pace() const override { return rate_.has_value(); }

  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override {}

  [[nodiscard]] SourceCounters counters() const override {
    return {.delivered = delivered_, .lost = lost_};
  }
  [[nodiscard]] std::string state() const override { return {}; }

 private:
  using Clock = std::chrono::steady_clock;

  /// Waits for frame `sequence_` and returns when it was complete; nullopt if that is after `end`.
  std::optional<Clock::time_point> wait_until(Clock::time_point end);

  std::unique_ptr<ReelPlayer> player_;
  std::optional<double> rate_;
  Clock::time_point start_;
  Clock::time_point pace_start_;  ///< when frame 0 began at the camera's rate, without any waits
  bool is_late_ = false;          ///< the next frame was not rendered when it was asked for
  std::uint64_t sequence_ = 0;
  std::atomic<std::uint64_t> delivered_ = 0, lost_ = 0;
};

}  // namespace slipstream
