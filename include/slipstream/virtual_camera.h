#pragma once

#include <atomic>
#include <chrono>

#include "slipstream/rendered_reel.h"
#include "slipstream/virtual_world.h"

namespace slipstream {

/// Whether bodies that move rest first, for a cycle, where the loop of their motion begins.
enum class FirstRest {
  none,
  once,
  until_rendered,  ///< the cycle is repeated until the loop is rendered
};

/// Script of a camera while the patterns are shown `cycles` times, as a seamless loop: bodies move
/// back and forth through their position at time 0, or rotate continuously if they only turn and
/// the frames last a full turn to within half a cycle. Each frame has its own noise. Scenes that
/// begin with a body of another size, as one that breathes, do not rest. Throws Error for less than
/// one cycle.
ReelScript looped_scene(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                        const Photometry& photometry, int cycles, FirstRest rest = FirstRest::none);

/// All frames of looped_scene without a rest, rendered. Throws Error as RenderedReel does.
std::vector<Frame> virtual_frames(const Scanner& scanner, const Scene& scene,
                                  const PatternSet& patterns, const Photometry& photometry,
                                  int cycles);

/// Script of a camera in front of a sheet that rests for `still_cycles` in each pose and moves to
/// the next within one cycle, cyclically, while the projector repeats the patterns of all sets. One
/// cycle of the last pose suffices. Throws Error for less than one pose or cycle.
ReelScript moved_board(const VirtualWorld& world, Body sheet,
                       const std::vector<Eigen::Isometry3d>& poses,
                       const std::vector<PatternSet>& sets, int still_cycles);

/// The first frame of a set; black if the set is unquantised.
Frame first_frame(const FrameSet& exposed);

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
  explicit VirtualCamera(Reel reel, std::optional<double> rate = std::nullopt)
      : VirtualCamera(std::make_shared<RenderedReel>(std::move(reel)), rate) {}

  /// Each frame once.
  explicit VirtualCamera(std::vector<Frame> loop, std::optional<double> rate = std::nullopt)
      : VirtualCamera(reel_of(std::move(loop)), rate) {}

  [[nodiscard]] FrameFormat format() const override { return player_.reel().format(); }
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

  ReelPlayer player_;
  std::optional<double> rate_;
  Clock::time_point start_;
  Clock::time_point pace_start_;  ///< when frame 0 began at the camera's rate, without any waits
  bool is_late_ = false;          ///< the next frame was not rendered when it was asked for
  std::uint64_t sequence_ = 0;
  std::atomic<std::uint64_t> delivered_ = 0, lost_ = 0;
};

}  // namespace slipstream
