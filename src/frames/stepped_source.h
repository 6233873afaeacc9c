#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "slipstream/frame_set.h"
#include "slipstream/frame_source.h"

namespace slipstream {

/// When light that the projector changes reaches a frame, from the return of PatternSink::show.
struct LightDelay {
  /// A frame that arrives earlier (with triggers: is triggered earlier) shows the old light alone.
  std::chrono::nanoseconds begins{};
  /// A frame that arrives later shows the new light alone.
  std::chrono::nanoseconds ends{};
  std::chrono::nanoseconds period{};  ///< between frames
};

/// Frames of one cycle and of the guard shown just after it, in pattern order.
struct GuardedCycle {
  FrameSet cycle, guard;  ///< both empty if the scene did not stand still
};

/// A camera in step with a projector that this program drives: shows a cycle of patterns in a loop,
/// and returns one frame of each that contains no other pattern, with its
/// FrameStamp::pattern_index. A pattern without such a frame counts as a lost frame.
///
/// Between two cycles it can show a guard: other patterns, whose frames next() does not return. It
/// takes one after each start(), and when frames come again after a pause of seconds.
class SteppedSource : public SourceOver {
 public:
  /// `patterns`: of one cycle. `triggered`: whether to use FrameSource::trigger; otherwise the
  /// camera runs freely. `sink` must outlive this; it is used from another thread meanwhile.
  /// `guard`: the patterns of a guard; none is taken if it is empty.
  SteppedSource(PatternSink& sink, std::unique_ptr<FrameSource> camera,
                const std::vector<Image<std::uint8_t>>& patterns, bool triggered,
                const std::vector<Image<std::uint8_t>>& guard = {});
  ~SteppedSource() override { stop(); }

  [[nodiscard]] FrameFormat format() const override { return source_->format(); }
  /// Starts the camera and measures the delay by a dozen flashes. Throws WorldError if the camera
  /// does not see them.
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override;
  [[nodiscard]] SourceCounters counters() const override;

  /// Measured by start().
  [[nodiscard]] const LightDelay& delay() const { return delay_; }
  /// From one pattern to the next: so long that a frame fits between two changes of light.
  [[nodiscard]] std::chrono::nanoseconds hold() const {
    return delay_.ends - delay_.begins + delay_.period;
  }

  [[nodiscard]] bool has_guard() const { return guard_ > 0; }
  /// Whether a guard is still to be taken: after a whole cycle, and compared with the cycle after
  /// it. May be called by any thread, as may the next two functions.
  [[nodiscard]] bool wants_guard() const;
  /// Takes a guard at the next chance, or cancels one.
  void want_guard(bool wanted);
  /// The newest guard, which is returned once.
  std::optional<GuardedCycle> take_guard();

 private:
  using Clock = std::chrono::steady_clock;
  using nanoseconds = std::chrono::nanoseconds;

  /// A pattern and when it was shown.
  struct Shown {
    std::uint64_t sequence = 0;  ///< of the cycles' patterns; in a guard, its pattern
    bool in_guard = false;
    Clock::time_point time;
  };

  /// The newest frame of each pattern, if it has come.
  using Taken = std::vector<std::optional<Frame>>;

  /// A guard that is to be taken, with the cycles before and after it.
  struct WantedGuard {
    Taken before{}, guard{}, after{};
    std::optional<std::uint64_t> followed_by{};  ///< sequence number; nullopt: it has not begun
    std::size_t shown = 0;                       ///< patterns of the guard, also those shown again
    int tries = 1;
  };

  /// When the frame would have arrived without delays of this machine, by the camera's clock.
  Clock::time_point arrival_of(const Frame& frame);
  /// The next frame, with the time that counts, into `frame`; nullopt on timeout.
  std::optional<Clock::time_point> take(Frame& frame, std::chrono::milliseconds timeout);
  void measure_delay();
  /// Shows a pattern of measure_delay and narrows the delay down by the frames that follow.
  void flash(std::size_t pattern);
  /// Shows the next pattern, of the cycle or of a guard that is due.
  void show_next();
  /// The pattern of a guard that is due, which then counts as shown; nullopt: the cycle's is due.
  std::optional<std::size_t> next_of_guard();
  /// The pattern that a frame of that time shows alone; nullopt if there is none.
  std::optional<Shown> shown_alone(Clock::time_point time);
  /// The caller holds `guard_mutex_`.
  void plan_guard(int tries);
  /// Copies a frame that belongs to a wanted guard, and ends that guard with its last frame.
  void keep_for_guard(const Frame& frame, const Shown& shown);
  void end_guard(WantedGuard done);
  /// Shows patterns to a camera that runs freely.
  void run();

  PatternSink& sink_;
  std::vector<Image<std::uint8_t>> patterns_;  ///< of the cycle, then of the guard
  const std::size_t cycle_, guard_;            ///< numbers of both
  const bool triggered_;
  LightDelay delay_;
  nanoseconds clock_offset_{};     ///< host time of a frame minus the camera's
  double light_ = 0, change_ = 0;  ///< mean grey levels, of 255
  Frame frame_;
  std::optional<Clock::time_point> came_;  ///< when the newest frame came
  std::mutex mutex_;         ///< guards sink_ while patterns are shown, and the next two
  std::deque<Shown> shown_;  ///< without a frame yet
  std::exception_ptr failure_;
  std::uint64_t next_ = 0;          ///< sequence number of the next pattern; of the showing thread
  mutable std::mutex guard_mutex_;  ///< guards the next two
  std::optional<WantedGuard> wanted_;
  std::optional<GuardedCycle> guarded_;
  std::atomic<std::uint64_t> taken_ = 0, missed_ = 0;
  std::atomic<bool> is_ending_ = false;
  std::thread thread_;
};

}  // namespace slipstream
