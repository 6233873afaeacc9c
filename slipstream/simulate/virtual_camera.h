#pragma once

#include <atomic>
#include <chrono>

#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// Simulates a camera while the patterns are shown `cycles` times, as a seamless loop: bodies move
/// back and forth through their position at time 0, or rotate continuously if they only turn and
/// the frames last a full turn to within half a cycle. Each frame has its own noise. Sets sequence
/// and pattern index of the stamps. Throws Error for less than one cycle or a photometry without
/// bits, and as take_scan.
std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles);

/// Simulates a camera in front of a sheet that rests for `still_cycles` in each pose and moves to
/// the next within one cycle, cyclically, while the projector repeats the patterns of all sets. One
/// cycle of the last pose suffices. Renders each frame of a pose once and calls `rendered` after
/// each pose. Throws Error for less than one pose or cycle, and as virtual_frames.
Reel moved_board(const VirtualWorld& world, Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                 const std::vector<PatternSet>& sets, int still_cycles,
                 const std::function<void()>& rendered);

/// The first frame of a set; black if the set is unquantised.
Frame first_frame(const FrameSet& exposed);

/// Repeats frames from memory endlessly, and counts them as a real camera does.
class VirtualCamera : public FrameSource {
 public:
  /// Frames buffered by a camera with its own pace; beyond these it loses the oldest.
  static constexpr int waiting_frames = 8;

  /// `reel`: frames of one format, which keep the pattern index of their stamps. `rate`: Hz;
  /// without it, frames arrive as fast as they are requested. Throws Error without frames, if their
  /// formats differ or if the rate is not positive.
  explicit VirtualCamera(Reel reel, std::optional<double> rate = std::nullopt);
  /// Each frame once.
  explicit VirtualCamera(std::vector<Frame> loop, std::optional<double> rate = std::nullopt)
      : VirtualCamera(reel_of(std::move(loop)), rate) {}

  [[nodiscard]] FrameFormat format() const override { return reel_.frames.front().format(); }
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

  Reel reel_;
  std::optional<double> rate_;
  Clock::time_point start_;
  std::uint64_t sequence_ = 0;
  std::atomic<std::uint64_t> delivered_ = 0, lost_ = 0;
};

}  // namespace slipstream
