#include "paper/cloud_views.h"

#include <array>

#include <gtest/gtest.h>

namespace slipstream::cloud_views_test {

TEST(CloudViews, TheNearerPointHidesTheOther) {
  // Two points on one line of sight, and two that span the picture.
  Cloud cloud({4, 1});
  const std::array<std::array<float, 4>, 4> points{
      {{0, 0, 500, 200}, {0, 0, 600, 50}, {-100, 0, 550, 100}, {100, 0, 550, 100}}};
  for (int i = 0; i < 4; ++i) {
    const auto& [x, y, z, grey] = points.at(static_cast<std::size_t>(i));
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
