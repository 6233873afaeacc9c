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

/// A camera in step with a projector that this program drives: shows a cycle of patterns in a loop,
/// and returns one frame of each that contains no other pattern, with its
/// FrameStamp::pattern_index. A pattern without such a frame counts as a lost frame.
class SteppedSource : public SourceOver {
 public:
  /// `patterns`: of one cycle. `triggered`: whether to use FrameSource::trigger; otherwise the
  /// camera runs freely. `sink` must outlive this; it is used from another thread meanwhile.
  SteppedSource(PatternSink& sink, std::unique_ptr<FrameSource> camera,
                std::vector<Image<std::uint8_t>> patterns, bool triggered);
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

 private:
  using Clock = std::chrono::steady_clock;
  using nanoseconds = std::chrono::nanoseconds;

  /// A pattern and when it was shown.
  struct Shown {
    std::uint64_t sequence = 0;
    Clock::time_point time;
  };

  /// When the frame would have arrived without delays of this machine, by the camera's clock.
  Clock::time_point arrival_of(const Frame& frame);
  /// The next frame, with the time that counts, into `frame`; nullopt on timeout.
  std::optional<Clock::time_point> take(Frame& frame, std::chrono::milliseconds timeout);
  void measure_delay();
  /// Shows a pattern of measure_delay and narrows the delay down by the frames that follow.
  void flash(std::size_t pattern);
  void show(std::uint64_t sequence);
  /// Shows patterns to a camera that runs freely.
  void run();

  PatternSink& sink_;
  std::vector<Image<std::uint8_t>> patterns_;
  const std::size_t cycle_;
  const bool triggered_;
  LightDelay delay_;
  nanoseconds clock_offset_{};     ///< host time of a frame minus the camera's
  double light_ = 0, change_ = 0;  ///< mean grey levels, of 255
  Frame frame_;
  std::mutex mutex_;         ///< guards sink_ while patterns are shown, and the next two
  std::deque<Shown> shown_;  ///< without a frame yet
  std::exception_ptr failure_;
  std::uint64_t next_ = 0;  ///< sequence number of the next pattern
  std::atomic<std::uint64_t> taken_ = 0, missed_ = 0;
  std::atomic<bool> is_ending_ = false;
  std::thread thread_;
};

}  // namespace slipstream
