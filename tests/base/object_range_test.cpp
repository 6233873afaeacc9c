#include "base/object_range.h"

#include <gtest/gtest.h>

namespace slipstream::object_range_test {

/// `count` depths in even steps from `low` to `high`.
void add(std::vector<float>& depths, int count, float low, float high) {
  for (int i = 0; i < count; ++i) {
    depths.push_back(low + (high - low) * static_cast<float>(i) / static_cast<float>(count));
  }
}

std::pair<float, float> range_of(std::vector<float> depths) {
  return range_of_object(depths);
}

TEST(ObjectRange, EndsBeforeAWallFarBehindTheObject) {
  std::vector<float> depths;
  add(depths, 600, 900, 905);  // the wall
  add(depths, 390, 500, 600);
  add(depths, 10, 600, 900);  // mixed pixels between them
  const auto [low, high] = range_of(depths);
  EXPECT_NEAR(low, 502, 3);
  EXPECT_NEAR(high, 598, 6);
}

TEST(ObjectRange, IsThatOfAllDepthsWithoutAGap) {
  std::vector<float> depths;
  add(depths, 1000, 500, 700);
  const auto [low, high] = range_of(depths);
  EXPECT_NEAR(low, 502, 1);
  EXPECT_NEAR(high, 698, 1);
}

TEST(ObjectRange, TakesFewPointsOrAFlatPlateForNoObject) {
  std::vector<float> few, flat;
  add(few, 950, 900, 905);
  add(few, 50, 500, 600);
  add(flat, 500, 900, 905);
  add(flat, 500, 500, 501);
  EXPECT_GT(range_of(few).second, 900);
  EXPECT_GT(range_of(flat).second, 900);
  EXPECT_EQ(range_of({7}), std::pair(7.0F, 7.0F));
}

}  // namespace slipstream::object_range_test
