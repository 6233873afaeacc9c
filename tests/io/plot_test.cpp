#include "io/plot.h"

#include <cmath>

#include <gtest/gtest.h>

namespace slipstream::plot_test {

TEST(Plot, RoundAxisSpansTheValuesWithRoundMarks) {
  const PlotAxis axis = round_axis(0.13, 6.28, 8);
  EXPECT_DOUBLE_EQ(axis.low, 0);
  EXPECT_DOUBLE_EQ(axis.high, 7);
  EXPECT_EQ(axis.marks.size(), 8U);
  EXPECT_DOUBLE_EQ(axis.marks[1], 1);
}

TEST(Plot, RoundAxisHasRoomAroundOneValue) {
  for (const double value : {0.0, 3.0, -2.0}) {
    const PlotAxis axis = round_axis(value, value, 8);
    EXPECT_LT(axis.low, value);
    EXPECT_GT(axis.high, value);
  }
}

TEST(Plot, DecadeAxisSpansWholePowersOfTen) {
  const PlotAxis axis = decade_axis(3e-8, 0.4, 10);
  EXPECT_DOUBLE_EQ(axis.low, -8);
  EXPECT_DOUBLE_EQ(axis.high, 0);
  EXPECT_EQ(axis.marks.size(), 9U);
  EXPECT_LE(decade_axis(1e-40, 1, 10).marks.size(), 11U);
}

}  // namespace slipstream::plot_test
