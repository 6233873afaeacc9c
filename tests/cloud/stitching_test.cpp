#include "cloud/stitching.h"

#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "base/numbers.h"
#include "geometry/rotation.h"
#include "slipstream/error.h"

namespace slipstream::stitching_test {

Lens small_camera() {
  Lens lens;
  lens.size = {160, 120};
  lens.intrinsic << 200, 0, 80, 0, 200, 60, 0, 0, 1;
  return lens;
}

/// A hilly ground around z = 0 of the base.
double height_at(double x, double y) {
  return 12 * std::sin(x / 25) * std::cos(y / 30) + 6 * std::sin((x + 2 * y) / 40);
}

/// The ground from a camera at this pose in the base.
Cloud seen_from(const Eigen::Isometry3d& camera) {
  const Lens lens = small_camera();
  Cloud cloud(lens.size);
  for_each_pixel_in_order(lens.size, [&](int column, int row) {
    const Eigen::Vector3d ray = ray_through(lens, Eigen::Vector2d(column, row));
    const Eigen::Vector3d direction = camera.linear() * ray;

    // Newton's method along the ray; the slope of the ground is small.
    double depth = -camera.translation().z() / direction.z();
    for (int step = 0; step < 30; ++step) {
      const Eigen::Vector3d at = camera.translation() + depth * direction;
      depth -= (at.z() - height_at(at.x(), at.y())) / direction.z();
    }
    cloud.x(column, row) = static_cast<float>(depth * ray.x());
    cloud.y(column, row) = static_cast<float>(depth * ray.y());
    cloud.z(column, row) = static_cast<float>(depth);
    cloud.validity(column, row) = Validity::valid;
  });
  return cloud;
}

/// A camera above the ground that looks down, turned about its axis and moved.
Eigen::Isometry3d above(double turn, double x, double y) {
  const Eigen::AngleAxisd down(180 * degree, Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd about(turn * degree, Eigen::Vector3d::UnitZ());
  return pose_from((down * about).toRotationMatrix(), {x, y, 300});
}

TEST(Stitching, ExactPosesMeet) {
  const Eigen::Isometry3d first = above(0, 0, 0), second = above(90, 15, -10);
  const Stitching found =
      stitched(seen_from(first), seen_from(second), small_camera(), first.inverse() * second);
  EXPECT_GT(found.points, 5000U);
  EXPECT_LT(found.median, 0.05);
  EXPECT_LT(found.offset.norm(), 0.05);
}

TEST(Stitching, FindsAnErrorOfHalfAMillimetreWithItsSign) {
  // Two views that differ by a turn of 180 degrees: an error of the camera's place on the tool
  // moves both views, in opposite directions.
  const Eigen::Isometry3d first = above(0, 0, 0), second = above(180, 5, 10);
  const Cloud from_first = seen_from(first), from_second = seen_from(second);

  for (int axis = 0; axis < 2; ++axis) {
    for (const double error : {-0.5, 0.5}) {
      const Eigen::Isometry3d wrong(Eigen::Translation3d(error * Eigen::Vector3d::Unit(axis)));
      const Eigen::Isometry3d believed = (first * wrong).inverse() * (second * wrong);
      const Stitching found = stitched(from_first, from_second, small_camera(), believed);

      // In the first camera's frame the first view is off by `error`, the second by its opposite.
      const Eigen::Vector3d expected = -2 * error * Eigen::Vector3d::Unit(axis);
      EXPECT_LT((found.offset - expected).norm(), 0.15) << found.offset.transpose();
      EXPECT_LT(found.left_median, found.median);
    }
  }
}

TEST(Stitching, RefusesViewsOfDifferentThings) {
  const Eigen::Isometry3d first = above(0, 0, 0);
  const Cloud cloud = seen_from(first);
  EXPECT_THROW(
      stitched(cloud, cloud, small_camera(), Eigen::Isometry3d(Eigen::Translation3d(1000, 0, 0))),
      Error);
  EXPECT_THROW(stitched(cloud, Cloud({4, 4}), small_camera(), Eigen::Isometry3d::Identity()),
               Error);
}

}  // namespace slipstream::stitching_test
