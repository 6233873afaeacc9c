// Neighbours found by cells are those found by comparing all points.
#include "merge/point_grid.h"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace slipstream::point_grid_test {

std::vector<Eigen::Vector3f> random_points(int count) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> place(-50, 50);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) points.emplace_back(place(random), place(random), place(random));
  return points;
}

TEST(PointGrid, FindsTheNearestPoint) {
  const std::vector<Eigen::Vector3f> points = random_points(2000);
  const PointGrid grid(points, 4);

  for (Eigen::Vector3f place : random_points(200)) {
    place += Eigen::Vector3f(0.3F, 20, -0.2F);
    constexpr float radius = 9;
    float least = radius;
    for (const Eigen::Vector3f& point : points) least = std::min(least, (point - place).norm());

    const auto found = grid.nearest(place, radius);
    ASSERT_EQ(found.has_value(), least < radius);
    if (found) EXPECT_FLOAT_EQ((points[*found] - place).norm(), least);
  }
}

TEST(ThinnedToCells, KeepsOnePointOfEachCell) {
  const std::vector<Eigen::Vector3f> points = random_points(5000);
  const auto kept = thinned_to_cells(points, 25);
  EXPECT_GE(kept.size(), 64U);
  EXPECT_LE(kept.size(), 125U);
}

}  // namespace slipstream::point_grid_test
