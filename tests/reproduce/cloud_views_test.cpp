#include "paper/cloud_views.h"

#include <array>

#include <gtest/gtest.h>

namespace slipstream::cloud_views_test {

TEST(CloudViews, TheNearerPointHidesTheOther) {
  // Two points on one line of sight, between many that span the picture.
  constexpr int count = 1002;
  Cloud cloud({count, 1});
  for (int i = 0; i < count; ++i) {
    std::array<float, 4> point{i % 2 == 0 ? -100.0F : 100.0F, 0, 550, 100};
    if (i == 500) point = {0, 0, 500, 200};
    if (i == 501) point = {0, 0, 600, 50};
    const auto& [x, y, z, grey] = point;
    cloud.x(i, 0) = x;
    cloud.y(i, 0) = y;
    cloud.z(i, 0) = z;
    cloud.intensity(i, 0) = grey;
  }
  const Image<std::uint8_t> front = seen_turned(cloud, 0, {100, 100});
  const Image<std::uint8_t> back = seen_turned(cloud, 180, {100, 100});
  EXPECT_GT(front(50, 50), back(50, 50));
  EXPECT_GT(back(50, 50), 0);
}

TEST(CloudViews, PicturesStandRowByRow) {
  const Image<std::uint8_t> dark({2, 1}, 10), bright({2, 1}, 90);
  const Image<std::uint8_t> all = side_by_side({dark, bright, bright}, 2);
  EXPECT_EQ(all.size(), (Size{4, 2}));
  EXPECT_EQ(all(1, 0), 10);
  EXPECT_EQ(all(2, 0), 90);
  EXPECT_EQ(all(0, 1), 90);
  EXPECT_EQ(all(3, 1), 0);
}

}  // namespace slipstream::cloud_views_test
