#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/registry.h"

namespace slipstream::strategy_test {

TEST(Strategy, IsMadeFromItsNameAndSettings) {
  const Strategy made =
      make_strategy("dual-frequency", {{"steps", 4}, {"low_steps", 3}, {"high", 8}});
  EXPECT_EQ(made, Strategy(DualFrequency{.steps = 4, .low_steps = 3, .high = 8}));
  EXPECT_EQ(step_counts(made), (std::vector{4, 3}));
  EXPECT_EQ(highest_frequency(made), 8);
  EXPECT_EQ(frame_count(made), 7);
  EXPECT_EQ(name_of(made), "dual-frequency");
  EXPECT_EQ(make_strategy(name_of(made), made.settings()).settings(), made.settings());
}

TEST(Strategy, RefusesWhatItDoesNotKnow) {
  EXPECT_THROW(make_strategy("gray-code", {}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"high", 16}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"steps", 2}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"steps", 3.5}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"steps", 1e12}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"frequency", -1}}), Error);
  EXPECT_THROW(make_strategy("pmp", {{"frequency", std::nan("")}}), Error);
  EXPECT_THROW(make_strategy("dual-frequency", {{"low", 2}}), Error);
  EXPECT_THROW(make_strategy("dual-frequency", {{"high", 15.5}}), Error);
  EXPECT_THROW(make_strategy("dual-frequency", {{"low_steps", 2}}), Error);
}

TEST(Strategy, KnowsWhetherItGivesACoordinate) {
  EXPECT_TRUE(has_coordinate(PhaseMeasuring{.steps = 3, .frequency = 1}));
  EXPECT_FALSE(has_coordinate(PhaseMeasuring{.steps = 3, .frequency = 16}));
  EXPECT_TRUE(has_coordinate(DualFrequency{}));
}

TEST(Strategy, DescribesEverySettingOnce) {
  const auto settings = strategy_settings();
  const auto steps = std::count_if(settings.begin(), settings.end(),
                                   [](const auto& setting) { return setting.name == "steps"; });
  EXPECT_EQ(steps, 1);
  EXPECT_TRUE(settings.front().strategies.starts_with("pmp 3, dual-frequency 3, pcmp 5, "));
}

TEST(Strategy, OffersUsualOnesThatGiveACoordinate) {
  const std::vector<Strategy> usual = usual_strategies();
  ASSERT_FALSE(usual.empty());
  EXPECT_EQ(label_of(usual.front()), "dual-frequency, high 16, low 1, steps 3");
  EXPECT_TRUE(std::all_of(usual.begin(), usual.end(),
                          [](const Strategy& strategy) { return has_coordinate(strategy); }));
}

TEST(Strategy, RefusesFrequenciesThatTheProjectorCannotShow) {
  EXPECT_NO_THROW(require_resolved(DualFrequency{.high = 16}, Axis::x, {1824, 2}));
  EXPECT_THROW(require_resolved(DualFrequency{.high = 16}, Axis::y, {64, 31}), Error);
  const Strategy modulated = ModulatedPhaseShifting{.carrier = 20};
  EXPECT_NO_THROW(require_resolved(modulated, Axis::x, {32, 40}));
  EXPECT_THROW(require_resolved(modulated, Axis::y, {32, 40}), Error);
}

TEST(ModulatedPhaseShifting, IsABaseTimesACarrierOrItsObliqueSinusoids) {
  using std::numbers::pi;
  const Strategy product =
      ModulatedPhaseShifting{.carrier_steps = 2, .periods = {1, 6}, .carrier = 20};
  const Strategy oblique = ModulatedPhaseShifting{.periods = {1, 6}, .carrier = 20};
  ASSERT_EQ(frame_count(product), 12);
  ASSERT_EQ(frame_count(oblique), 12);
  for (const double y : {0.0, 0.21, 0.8}) {
    for (const double across : {0.0, 0.013, 0.6}) {
      for (int n = 0; n < 12; ++n) {
        const double base = pi * (n < 6 ? 1 : 6) * y, carrier = 2 * pi * 20 * across;
        const int i = n % 6;
        EXPECT_NEAR(product.shape(n, y, across),
                    0.5 + 0.5 * std::cos(base - 2 * pi * (i / 2) / 3) *
                              std::cos(carrier - pi * (i % 2) / 2),
                    1e-12);
        EXPECT_NEAR(
            oblique.shape(n, y, across),
            0.5 + 0.5 * std::cos(base + (i < 3 ? carrier : -carrier) - 2 * pi * (i % 3) / 3),
            1e-12);
      }
    }
  }
  EXPECT_EQ(step_counts(oblique), (std::vector<int>{3, 3}));
  EXPECT_TRUE(step_counts(product).empty());
  EXPECT_EQ(highest_frequency(product), 6);
}

}  // namespace slipstream::strategy_test
