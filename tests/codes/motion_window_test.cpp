#include "codes/motion_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "response/correction.h"
#include "slipstream/error.h"
#include "slipstream/gray_code.h"
#include "slipstream/layout.h"
#include "slipstream/strategy.h"

namespace slipstream::motion_window_test {

constexpr double two_pi = 2 * std::numbers::pi;

/// What a band sees of A + B cos of a phase that moves by `speed` from frame to frame, phi in the
/// middle of the window.
struct Seen {
  double mean = 0, modulation = 0, error = 0;
};

Seen seen(const Band& band, int N, int first, double phi, double speed) {
  constexpr double A = 100, B = 50;
  double mean = 0, C = 0, S = 0;
  const auto frames = static_cast<int>(band.mean.size());
  for (int n = 0; n < frames; ++n) {
    const double moved = phi + speed * (n - (frames - 1) / 2.0);
    const double I = A + B * std::cos(moved - two_pi * (n + first) / N);
    mean += band.mean[static_cast<std::size_t>(n)] * I;
    C += band.cosine[static_cast<std::size_t>(n)] * I;
    S += band.sine[static_cast<std::size_t>(n)] * I;
  }
  return {mean, std::hypot(C, S), std::remainder(std::atan2(S, C) - phi, two_pi)};
}

TEST(MotionWindow, IsBinomialForFourSteps) {
  const Band band = motion_window(PhaseMeasuring{4, 1}.layout(), 2).bands.front();
  const std::vector<double> cosines{1, 0, -4, 0, 3, 0}, sines{0, 3, 0, -4, 0, 1};
  for (std::size_t n = 0; n < 6; ++n) {
    EXPECT_NEAR(band.cosine[n], cosines[n] / 8, 1e-15) << n;
    EXPECT_NEAR(band.sine[n], sines[n] / 8, 1e-15) << n;
  }
}

RC_GTEST_PROP(MotionWindow, SeesWhatStandsStillAsOneCycleDoes, ()) {
  const int N = *rc::gen::inRange(3, 13), extra = *rc::gen::inRange(0, 9);
  const int first = *rc::gen::inRange(0, N);
  const double phi = *rc::gen::inRange(0, 6283) / 1000.0;
  const Band band = motion_window(PhaseMeasuring{N, 4}.layout(), extra, first).bands.front();
  const Seen still = seen(band, N, first, phi, 0);
  RC_ASSERT(std::abs(still.mean - 100) < 1e-9);
  RC_ASSERT(std::abs(still.modulation - 50) < 1e-9);
  RC_ASSERT(std::abs(still.error) < 1e-11);
}

RC_GTEST_PROP(MotionWindow, ErrsByNoMoreThanTheRippleThatIsTold, ()) {
  const int N = *rc::gen::inRange(3, 9), extra = *rc::gen::inRange(0, 5);
  const double speed = *rc::gen::inRange(-300, 301) / 1000.0;
  const Layout cycle = PhaseMeasuring{N, 4}.layout();
  const Band band = motion_window(cycle, extra).bands.front();
  double worst = 0;
  for (int i = 0; i < 200; ++i) {
    worst = std::max(worst, std::abs(seen(band, N, 0, two_pi * i / 200, speed).error));
  }
  const double told = motion_ripple(cycle, extra, speed);
  RC_ASSERT(worst <= told + 1e-9);
  RC_ASSERT(worst >= 0.99 * told - 1e-9);
}

/// Cues and channels stand in the frames beside a phase that moves: they are read, and it is, as
/// what is there in the middle of the window would be at rest.
TEST(MotionWindow, ReadsCuesThroughMotion) {
  constexpr double y = 0.37, speed = 0.04;
  for (const int N : {3, 4, 5, 6}) {
    const PhaseChannelMultiplexing cycle{.steps = N};
    const double moved = speed / two_pi / cycle.f_h();
    for (const int first : {0, 1}) {
      std::array<double, 3> phase_error{}, cue_error{};
      for (const int extra : {0, 2, 4}) {
        const Layout window = motion_window(cycle.layout(), extra, first);
        const auto off = [&](const auto& read) {
          return std::abs(std::remainder(read(moved) - read(0), two_pi));
        };
        const auto sum = [&](const std::vector<double>& weights, double step) {
          double total = 0;
          for (int n = 0; n < window.frames; ++n) {
            const double at = y + step * (n - (window.frames - 1) / 2.0);
            total += weights[static_cast<std::size_t>(n)] * cycle.shape((n + first) % N, at);
          }
          return total;
        };
        const auto phase_of = [&](const Band& band) {
          return
              [&](double step) { return std::atan2(sum(band.sine, step), sum(band.cosine, step)); };
        };
        const auto at = static_cast<std::size_t>(extra / 2);
        phase_error[at] = off(phase_of(window.bands.front()));
        cue_error[at] = window.cue
                            ? off([&](double step) { return sum(window.cue->weights, step); })
                            : off(phase_of(window.bands.back()));
      }
      // What is left of the phase is by the cue, which moves too.
      EXPECT_LT(phase_error[1], std::min(0.005, 0.7 * phase_error[0])) << N << " from " << first;
      EXPECT_LT(phase_error[2], 0.005);
      EXPECT_LT(cue_error[1], 0.15 * cue_error[0]) << N << " from " << first;
      EXPECT_LT(cue_error[2], 0.3 * cue_error[0]);
    }
  }
}

TEST(MotionWindowMotionRipple, FallsByAPowerOfTheSpeedForEachFrame) {
  for (const int N : {3, 4, 5, 6, 8}) {
    const Layout cycle = PhaseMeasuring{N, 1}.layout();
    for (int extra = 0; extra < 4; ++extra) {
      const double fast = motion_ripple(cycle, extra, 0.02),
                   slow = motion_ripple(cycle, extra, 0.01);
      EXPECT_NEAR(std::log2(fast / slow), extra + 1, 0.1) << N << ", " << extra;
    }
  }
}

TEST(MotionWindow, RefusesWhatIsNoCycleOfOneSinusoid) {
  EXPECT_THROW(motion_window(PhaseMeasuring{4, 1}.layout(), -1), Error);
  EXPECT_THROW(motion_window(PhaseMeasuring{4, 1}.layout(), 17), Error);
  for (const Strategy& strategy :
       {Strategy(DualFrequency{}), Strategy(GrayPhase{}), Strategy(TwoPlusOne{}),
        Strategy(ModulatedPhaseShifting{.periods = {1}})}) {
    EXPECT_THROW(motion_window(strategy.layout(), 2), Error) << strategy.name();
  }
}

TEST(MotionWindowStrategyInMotion, ShowsTheCycleFromThatPatternOn) {
  const Strategy steps = PhaseMeasuring{3, 4}, window = steps.in_motion(2, 1);
  EXPECT_EQ(frame_count(window), 5);
  for (int n = 0; n < 5; ++n) EXPECT_EQ(window.shape(n, 0.3), steps.shape((n + 1) % 3, 0.3));
}

}  // namespace slipstream::motion_window_test
