#include "slipstream/codes/strategy_design.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/registry.h"

namespace slipstream::strategy_design_test {

TEST(StrategyDesign, OffersTheBestOfEachKind) {
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

TEST(StrategyDesign, TakesTheFewestFramesThatReachANoise) {
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

TEST(StrategyDesign, RefusesWhatIsOutOfRange) {
  EXPECT_THROW(strategy_designs({.frames = 2}), Error);
  EXPECT_THROW(strategy_designs({.coordinate_sigma = 0}), Error);
  EXPECT_THROW(strategy_designs({.alpha = 0}), Error);
  EXPECT_THROW(strategy_designs({.noise_variance = -1}), Error);
  EXPECT_THROW(strategy_designs({.success = 1}), Error);
  EXPECT_THROW(strategy_designs({.most_periods = 1}), Error);
}

}  // namespace slipstream::strategy_design_test
