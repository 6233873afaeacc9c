#include "codes/design.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/phase_channel_multiplexing.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"

namespace slipstream::multiplexing_design_test {

TEST(Design, MultiplexingDesignMeetsItsGoalAtTheLeastNoise) {
  for (const int steps : {3, 4, 5, 8}) {
    const DesignGoal goal{.steps = steps, .alpha = 0.4, .ambient = -5};
    const Design best = best_design(goal);
    EXPECT_NO_THROW(best.strategy.require_valid());
    EXPECT_NO_THROW(require_valid(best.light));
    EXPECT_GE(best.success, goal.success);
    for (const Design& other : designs_by_frequency(goal)) {
      EXPECT_GE(other.success, goal.success);
      EXPECT_GE(other.coordinate_sigma, best.coordinate_sigma);
    }
    // The darkest and the brightest frame stay off both ends.
    const auto& [alpha_p, beta_p] = best.light;
    EXPECT_GT(goal.alpha * (beta_p + goal.ambient) + goal.ambient, 0);
    EXPECT_LT(alpha_p + beta_p + 2 * goal.ambient, 255);
  }
}

TEST(Design, MultiplexingDesignKeepsThreeStandardDeviationsOffBothEnds) {
  for (const double noise_variance : {0.5, 1.6, 2.0, 3.0}) {
    const DesignGoal goal{.alpha = 0.5, .noise_variance = noise_variance};
    const auto& [alpha_p, beta_p] = brightest_light(goal);
    const double clear = 3 * std::sqrt(noise_variance);
    EXPECT_GE(goal.alpha * beta_p, clear) << noise_variance;
    EXPECT_LE(alpha_p + beta_p, 255 - clear) << noise_variance;
  }
}

TEST(Design, MultiplexingDesignAsksLessOfBetterLight) {
  const auto sigma = [](double alpha, double noise_variance) {
    return best_design({.alpha = alpha, .noise_variance = noise_variance}).coordinate_sigma;
  };
  EXPECT_LT(sigma(0.8, 1.6), sigma(0.4, 1.6));
  EXPECT_LT(sigma(0.4, 1.6), sigma(0.4, 4));
}

TEST(Design, MultiplexingDesignDoubtsPeriodsOfFewPixels) {
  const auto doubt = [](double high, int pixels) {
    return doubt_about({.strategy = DualFrequency{.high = high}, .projector = {pixels, 1000}});
  };
  EXPECT_EQ(doubt(320, 1280), "");
  EXPECT_EQ(doubt(500, 0), "");
  const std::string told = doubt(500, 1280);
  for (const char* part : {"500 periods", "2.56 pixels", "Nyquist", "23 %", "320 periods"}) {
    EXPECT_NE(told.find(part), std::string::npos) << told;
  }
}

TEST(Design, MultiplexingDesignDoubtsCuesByTheirOwnShare) {
  EXPECT_EQ(doubt_about({.strategy = PeriodCoded{}}), "");
  const std::string told = doubt_about({.strategy = PeriodCoded{.high = 32}});
  EXPECT_NE(told.find("only 64 %"), std::string::npos) << told;
  EXPECT_EQ(told.find("`share`"), std::string::npos) << "it has none: " << told;
}

TEST(Design, MultiplexingDesignRefusesWhatCannotBe) {
  EXPECT_THROW(best_design({.steps = 2}), Error);
  EXPECT_THROW(best_design({.alpha = 0}), Error);
  EXPECT_THROW(best_design({.success = 1}), Error);
  EXPECT_THROW(best_design({.noise_variance = std::nan("")}), Error);
  EXPECT_THROW(best_design({.alpha = 0.02, .ambient = -7}), Error) << "underflows at any beta_p";
  EXPECT_THROW(best_design({.steps = 3, .alpha = 0.2, .noise_variance = 400, .success = 0.999}),
               Error);
}

}  // namespace slipstream::multiplexing_design_test

namespace slipstream::strategy_design_test {

TEST(Design, StrategyDesignOffersTheBestOfEachKind) {
  const std::vector<StrategyDesign> designs = strategy_designs({.frames = 10});
  ASSERT_GE(designs.size(), 6U);
  for (std::size_t i = 0; i < designs.size(); ++i) {
    const auto& [strategy, success, sigma] = designs[i];
    SCOPED_TRACE(label_of(strategy));
    EXPECT_LE(frame_count(strategy), 10);
    EXPECT_LE(highest_frequency(strategy), 64);
    EXPECT_GE(success, 0.999);
    EXPECT_TRUE(has_coordinate(strategy));
    if (i > 0) EXPECT_GE(sigma, designs[i - 1].coordinate_sigma);
  }
  const auto has = [&](const char* name) {
    return std::any_of(designs.begin(), designs.end(), [&](const StrategyDesign& design) {
      return design.strategy.name() == name;
    });
  };
  for (const char* name : {"pmp", "dual-frequency", "multi-frequency", "gray-phase", "pcmp"}) {
    EXPECT_TRUE(has(name)) << name;
  }
}

TEST(Design, StrategyDesignTakesTheFewestFramesThatReachANoise) {
  const double wanted = 2e-4;
  for (const auto& [strategy, success, sigma] :
       strategy_designs({.frames = 16, .coordinate_sigma = wanted})) {
    SCOPED_TRACE(label_of(strategy));
    EXPECT_LE(sigma, wanted);
    const int fewer = frame_count(strategy) - 1;
    if (fewer < 3) continue;
    for (const StrategyDesign& other :
         strategy_designs({.frames = fewer, .coordinate_sigma = wanted})) {
      EXPECT_NE(other.strategy.name(), strategy.name());
    }
  }
}

TEST(Design, StrategyDesignRefusesWhatIsOutOfRange) {
  EXPECT_THROW(strategy_designs({.frames = 2}), Error);
  EXPECT_THROW(strategy_designs({.coordinate_sigma = 0}), Error);
  EXPECT_THROW(strategy_designs({.alpha = 0}), Error);
  EXPECT_THROW(strategy_designs({.noise_variance = -1}), Error);
  EXPECT_THROW(strategy_designs({.success = 1}), Error);
  EXPECT_THROW(strategy_designs({.most_periods = 1}), Error);
}

}  // namespace slipstream::strategy_design_test
