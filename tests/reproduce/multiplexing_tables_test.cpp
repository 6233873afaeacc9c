// Tables 3.1 to 3.3, 3.5 and 3.7 of Liu 2010.
#include "paper/multiplexing_tables.h"

#include <cmath>

#include <gtest/gtest.h>

#include "codes/design.h"
#include "slipstream/error.h"

namespace slipstream::multiplexing_tables_test {

class MultiplexingTablesUnwrappingTable : public testing::TestWithParam<int> {};

constexpr Size picture{480, 360};

TEST_P(MultiplexingTablesUnwrappingTable, IsRecomputedImprovedAndPredicted) {
  const auto table = unwrapping_table(GetParam(), {.size = picture});
  ASSERT_EQ(table.size(), 9U);
  for (const UnwrappingCell& cell : table) {
    SCOPED_TRACE(testing::Message()
                 << "f_h " << cell.high << ", c_1 " << cell.c1 << ", alpha_p " << cell.alpha_p);
    EXPECT_NEAR(cell.recomputed, cell.published, 0.35);
    EXPECT_GE(cell.improved, 99.8);
    const PhaseChannelMultiplexing strategy{
        .steps = cell.steps, .high = cell.high, .share = cell.c1, .reference = {}};
    const PatternLight light{.alpha_p = cell.alpha_p, .beta_p = 255 - cell.alpha_p};
    const double predicted = 100 * predicted_unwrapping(strategy.layout(), light, 0.5, -7, 1.55);
    // The prediction takes the cue of 5 steps for the circle that the published rule cuts open.
    EXPECT_NEAR(predicted, cell.steps < 5 ? cell.recomputed : cell.improved, 0.6);
  }
}

TEST_P(MultiplexingTablesUnwrappingTable, IsImprovedAtDepthEdgesAndNoPixelMadeWorse) {
  const UnwrappingTrial trial{.surface = UnwrappingTrial::Surface::stepped, .size = picture};
  for (const UnwrappingCell& cell : unwrapping_table(GetParam(), trial)) {
    SCOPED_TRACE(testing::Message()
                 << "f_h " << cell.high << ", c_1 " << cell.c1 << ", alpha_p " << cell.alpha_p);
    EXPECT_GE(cell.improved, 99.8);
    EXPECT_EQ(cell.worse, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(N, MultiplexingTablesUnwrappingTable, testing::Values(3, 4, 5));

class MultiplexingTablesVarianceRatioTable : public testing::TestWithParam<int> {};

TEST_P(MultiplexingTablesVarianceRatioTable, IsAsPredictedWithinFivePercent) {
  const auto table = variance_ratio_table(GetParam(), {.camera = {320, 240}});
  ASSERT_EQ(table.size(), 9U);
  for (const VarianceRatioCell& cell : table) {
    EXPECT_NEAR(cell.measured / cell.predicted, 1, 0.05)
        << "N " << cell.steps << ", f_h " << cell.high << ", c_1 " << cell.c1;
  }
}

TEST_P(MultiplexingTablesVarianceRatioTable, ComesNearTheExperimentOfFoam) {
  double ideal = 0, of_foam = 0;  // squares of what is missing, shares of the theory
  for (const VarianceRatioCell& cell : variance_ratio_table(GetParam(), {.camera = {320, 240}})) {
    ideal += std::pow((cell.measured - cell.published) / cell.predicted, 2) / 9;
    of_foam += std::pow((cell.of_foam - cell.published) / cell.predicted, 2) / 9;
  }
  EXPECT_LT(std::sqrt(of_foam), 0.6 * std::sqrt(ideal));
  EXPECT_LT(std::sqrt(of_foam), 0.12);
}

INSTANTIATE_TEST_SUITE_P(N, MultiplexingTablesVarianceRatioTable, testing::Values(4, 5));

TEST(MultiplexingTables, ReproducedTablesRefuseStepsThatHaveNone) {
  EXPECT_THROW(unwrapping_table(6), Error);
  EXPECT_THROW(variance_ratio_table(6), Error);
}

}  // namespace slipstream::multiplexing_tables_test
