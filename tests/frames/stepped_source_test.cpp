// A camera in step with a projector, by doubles of both that share a clock.
#include "frames/stepped_source.h"

#include <atomic>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "slipstream/error.h"

namespace slipstream::stepped_source_test {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using Seconds = std::chrono::duration<double>;

/// A projector whose pictures, of one grey level each, become light a while after they are shown.
class Projector : public PatternSink {
 public:
  explicit Projector(milliseconds delay) : delay_(delay) {}

  [[nodiscard]] std::optional<Size> size() const override { return Size{8, 8}; }
  void load(std::vector<Image<std::uint8_t>> patterns) override {
    const std::lock_guard lock(mutex_);
    patterns_ = std::move(patterns);
  }
  void show(std::size_t n) override {
    const std::lock_guard lock(mutex_);
    history_.emplace_back(Clock::now() + delay_, patterns_.at(n)(0, 0));
  }
  [[nodiscard]] std::uint64_t shown() const override { return history_.size(); }
  [[nodiscard]] std::string state() const override { return ""; }

  /// Mean light between two times, grey levels.
  [[nodiscard]] double light(Clock::time_point begin, Clock::time_point end) {
    const std::lock_guard lock(mutex_);
    double sum = 0;
    for (std::size_t i = 0; i < history_.size(); ++i) {
      const auto from = std::max(begin, history_[i].first);
      const auto to = i + 1 < history_.size() ? std::min(end, history_[i + 1].first) : end;
      if (to > from) sum += Seconds(to - from).count() * history_[i].second;
    }
    return ambient + sum / Seconds(end - begin).count();
  }

  std::atomic<int> ambient = 0;  ///< light of the room, grey levels

 private:
  const milliseconds delay_;
  std::mutex mutex_;
  std::vector<Image<std::uint8_t>> patterns_;
  std::vector<std::pair<Clock::time_point, double>> history_;
};

/// Exposes one frame after another, or when triggered; delivers each a while later.
class Camera : public FrameSource {
 public:
  struct Timing {
    milliseconds period{10}, exposure{8}, transfer{15};
    bool triggered = false;
    bool blind = false;
  };
  Camera(Projector& projector, Timing timing) : projector_(projector), timing_(timing) {}

  [[nodiscard]] FrameFormat format() const override { return {{8, 8}, 8}; }
  [[nodiscard]] bool has_own_pace() const override { return true; }
  void start() override { begin_ = Clock::now(); }
  void stop() override {}
  void trigger() override { triggers_.push_back(Clock::now()); }
  [[nodiscard]] SourceCounters counters() const override { return {}; }
  [[nodiscard]] std::string state() const override { return ""; }

  Arrival next(Frame& frame, milliseconds timeout) override {
    if (timing_.triggered && triggers_.empty()) {
      std::this_thread::sleep_for(timeout);
      return Arrival::nothing;
    }
    const auto begins = timing_.triggered ? triggers_.front() : begin_ + number_ * timing_.period;
    const auto ends = begins + timing_.exposure, arrives = ends + timing_.transfer;
    const auto deadline = Clock::now() + timeout;
    std::this_thread::sleep_until(std::min(arrives, deadline));
    if (arrives > deadline) return Arrival::nothing;
    if (timing_.triggered) triggers_.pop_front();
    const double level = timing_.blind ? 7 : projector_.light(begins, ends);
    frame.pixels = Image<std::uint8_t>({8, 8}, static_cast<std::uint8_t>(std::lround(level)));
    frame.stamp = {.sequence = static_cast<std::uint64_t>(number_++),
                   .pattern_index = std::nullopt,
                   .device_time = {},
                   .host_time = arrives};
    return Arrival::frame;
  }

 private:
  Projector& projector_;
  const Timing timing_;
  Clock::time_point begin_;
  int number_ = 0;
  std::deque<Clock::time_point> triggers_;
};

std::vector<Image<std::uint8_t>> patterns() {
  std::vector<Image<std::uint8_t>> levels;
  for (const int level : {200, 20, 120, 60}) levels.emplace_back(Size{8, 8}, level);
  return levels;
}

class SteppedSources : public testing::TestWithParam<Camera::Timing> {};

// Every frame shows one pattern alone, in turn; a missed one leaves a gap.
TEST_P(SteppedSources, ReturnOneFrameOfEachPattern) {
  Projector projector(milliseconds(23));
  SteppedSource source(projector, std::make_unique<Camera>(projector, GetParam()), patterns(),
                       GetParam().triggered);
  source.start();
  Frame frame(source.format());
  std::uint64_t expected = 0;
  const auto begin = Clock::now();
  for (int i = 0; i < 24; ++i) {
    ASSERT_EQ(source.next(frame, milliseconds(2000)), Arrival::frame);
    EXPECT_GE(frame.stamp.sequence, expected);
    expected = frame.stamp.sequence + 1;
    const auto n = static_cast<std::size_t>(frame.stamp.sequence % 4);
    EXPECT_EQ(frame.stamp.pattern_index, static_cast<int>(n));
    EXPECT_NEAR(std::get<Image<std::uint8_t>>(frame.pixels)(3, 3), patterns()[n](0, 0), 1) << i;
  }
  source.stop();
  std::printf("%.1f patterns per s, %lu missed; light after %.1f to %.1f ms\n",
              24 / Seconds(Clock::now() - begin).count(), source.counters().lost,
              1e3 * Seconds(source.delay().begins).count(),
              1e3 * Seconds(source.delay().ends).count());
  EXPECT_EQ(source.counters().delivered, 24U);
  EXPECT_EQ(source.counters().lost + 24, expected);
}

INSTANTIATE_TEST_SUITE_P(Cameras, SteppedSources,
                         testing::Values(Camera::Timing{}, Camera::Timing{.triggered = true},
                                         Camera::Timing{.period = milliseconds(33),
                                                        .exposure = milliseconds(30),
                                                        .transfer = milliseconds(60)}));

/// Patterns of a guard, none of which a cycle has.
std::vector<Image<std::uint8_t>> guard_patterns() {
  std::vector<Image<std::uint8_t>> levels;
  for (const int level : {90, 160, 40}) levels.emplace_back(Size{8, 8}, level);
  return levels;
}

double level_of(const FrameSet& frames, int n) {
  return frames.views().visit([&](const auto& views) {
    return static_cast<double>(views[static_cast<std::size_t>(n)](3, 3));
  });
}

/// Whether a frame shows one pattern alone.
bool is_alone(double level, const Image<std::uint8_t>& pattern) {
  return std::abs(level - pattern(0, 0)) <= 1;
}

/// How many frames of a cycle and its guard show another pattern too.
int mixed_frames(const std::optional<GuardedCycle>& taken) {
  EXPECT_TRUE(taken && taken->cycle.count() == 4 && taken->guard.count() == 3);
  if (!taken) return 0;

  int mixed = 0;
  for (int n = 0; n < taken->cycle.count(); ++n) {
    if (!is_alone(level_of(taken->cycle, n), patterns()[static_cast<std::size_t>(n)])) ++mixed;
  }
  for (int n = 0; n < taken->guard.count(); ++n) {
    if (!is_alone(level_of(taken->guard, n), guard_patterns()[static_cast<std::size_t>(n)])) {
      ++mixed;
    }
  }
  return mixed;
}

/// Takes a guard after the start and one on request, with one cancelled between them; returns how
/// many frames show two patterns.
int mixed_frames_with_guards(const Camera::Timing& timing) {
  Projector projector(milliseconds(23));
  SteppedSource source(projector, std::make_unique<Camera>(projector, timing), patterns(),
                       timing.triggered, guard_patterns());
  source.start();

  Frame frame(source.format());
  std::uint64_t expected = 0;
  int mixed = 0;
  const auto next_guard = [&] {
    std::optional<GuardedCycle> taken;
    for (int i = 0; i < 200 && !taken; ++i) {
      taken = source.take_guard();
      if (source.next(frame, milliseconds(2000)) != Arrival::frame) continue;

      EXPECT_GE(frame.stamp.sequence, expected);
      expected = frame.stamp.sequence + 1;
      const auto n = static_cast<std::size_t>(frame.stamp.sequence % 4);
      const double level = std::get<Image<std::uint8_t>>(frame.pixels)(3, 3);
      if (!is_alone(level, patterns()[n])) ++mixed;
    }
    return taken;
  };

  for (int run = 0; run < 2; ++run) {
    EXPECT_TRUE(source.wants_guard());
    mixed += mixed_frames(next_guard());
    EXPECT_FALSE(source.wants_guard());

    // One that is cancelled while it is shown leaves nothing to the next.
    source.want_guard(true);
    for (int i = 0; i < 9; ++i) source.next(frame, milliseconds(2000));
    source.want_guard(false);
    EXPECT_FALSE(source.wants_guard());
    expected = 0;
    source.want_guard(true);
  }
  source.stop();
  return mixed;
}

// Its frames, and those of the cycle before, are each of one pattern alone; what next() returns is
// as without it. Where the machine halts this process just after a picture was shown, its time is
// not known: that spoils one run, not three in a row.
TEST_P(SteppedSources, TakeAGuardBetweenTwoCycles) {
  int mixed = 1;
  for (int run = 0; run < 3 && mixed > 0; ++run) mixed = mixed_frames_with_guards(GetParam());
  EXPECT_EQ(mixed, 0);
}

// Its light differs by more than noise from each cycle to the next.
TEST(SteppedSource, TakesNoGuardOfASceneThatChanges) {
  Projector projector(milliseconds(5));
  SteppedSource source(projector, std::make_unique<Camera>(projector, Camera::Timing{}), patterns(),
                       false, guard_patterns());
  source.start();

  Frame frame(source.format());
  std::optional<GuardedCycle> taken;
  for (int i = 0; i < 300 && !taken; ++i) {
    source.next(frame, milliseconds(2000));
    projector.ambient = 3 * i;
    taken = source.take_guard();
  }
  source.stop();

  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->cycle.count(), 0);
  EXPECT_EQ(taken->guard.count(), 0);
}

TEST(SteppedSource, SaysThatTheCameraDoesNotSeeTheProjector) {
  Projector projector(milliseconds(5));
  SteppedSource source(projector,
                       std::make_unique<Camera>(projector, Camera::Timing{.blind = true}),
                       patterns(), false);
  EXPECT_THROW(source.start(), WorldError);
}

/// A projector that fails once.
class BreakingProjector : public Projector {
 public:
  using Projector::Projector;

  void show(std::size_t n) override {
    if (breaks.exchange(false)) throw WorldError("the cable is loose");
    Projector::show(n);
  }

  std::atomic<bool> breaks = false;
};

TEST(SteppedSource, GoesOnAfterAFailureOnceStartedAgain) {
  BreakingProjector projector(milliseconds(23));
  SteppedSource source(projector, std::make_unique<Camera>(projector, Camera::Timing{}), patterns(),
                       false);
  source.start();
  Frame frame(source.format());
  EXPECT_EQ(source.next(frame, milliseconds(2000)), Arrival::frame);

  projector.breaks = true;
  const auto take_many = [&] {
    for (int i = 0; i < 100; ++i) source.next(frame, milliseconds(100));
  };
  EXPECT_THROW(take_many(), WorldError);

  source.stop();
  source.start();
  EXPECT_EQ(source.next(frame, milliseconds(2000)), Arrival::frame);
  source.stop();
}

}  // namespace slipstream::stepped_source_test
