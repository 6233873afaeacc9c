#include "calibrate/pixel_derivatives.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace slipstream::pixel_derivatives_test {

/// Jacobian of `value` at `numbers`, by central differences.
template <std::size_t Count, class Value>
Eigen::MatrixXd differences(const std::array<double, Count>& numbers, const Value& value) {
  Eigen::MatrixXd result(value(numbers.data()).size(), static_cast<Eigen::Index>(Count));
  for (std::size_t i = 0; i < Count; ++i) {
    std::array<double, Count> more = numbers, less = numbers;
    const double step = 1e-6 * std::max(1.0, std::abs(numbers[i]));
    more[i] += step;
    less[i] -= step;
    result.col(static_cast<Eigen::Index>(i)) =
        (value(more.data()) - value(less.data())) / (2 * step);
  }
  return result;
}

void expect_close(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
  EXPECT_LT((found - expected).norm(), 1e-7 * expected.norm()) << found << "\n\n" << expected;
}

TEST(PixelDerivatives, OfAMovedPointAreThoseOfDifferences) {
  const Eigen::Vector3d point(20, -30, 5);
  for (const double angle : {0.0, 9e-4, 0.02, 1.0, 3.0}) {
    const Eigen::Vector3d turn = angle * Eigen::Vector3d(0.6, -0.64, 0.48);
    const std::array<double, 6> pose{turn.x(), turn.y(), turn.z(), 4, -7, 500};
    const MovedPoint moved = moved_point(pose.data(), point);
    const Eigen::Vector3d expected =
        Eigen::AngleAxisd(angle, turn.stableNormalized()) * point + Eigen::Vector3d(4, -7, 500);
    EXPECT_LT((moved.point - expected).norm(), 1e-10);
    expect_close(moved.by_pose, differences(pose, [&](const double* p) -> Eigen::VectorXd {
                   return moved_point(p, point).point;
                 }));
    const std::array<double, 3> place{20, -30, 5};
    expect_close(moved.by_point, differences(place, [&](const double* p) -> Eigen::VectorXd {
                   return moved_point(pose.data(), {p[0], p[1], p[2]}).point;
                 }));
  }
}

TEST(PixelDerivatives, OfALensAreThoseOfDifferences) {
  const std::array<double, lens_number_count> lens{830,  845,   318,   244,  -0.2,  0.08,
                                                   1e-3, -2e-3, 0.03,  0.05, -0.04, 0.02,
                                                   2e-3, 1e-3,  -3e-3, 4e-3};
  const std::array<double, 3> place{150, -120, 500};
  const Eigen::Vector3d point(place[0], place[1], place[2]);
  const SeenPoint seen = seen_point(lens.data(), point);
  expect_close(seen.by_lens, differences(lens, [&](const double* numbers) -> Eigen::VectorXd {
                 return seen_point(numbers, point).pixel;
               }));
  expect_close(seen.by_point, differences(place, [&](const double* p) -> Eigen::VectorXd {
                 return seen_point(lens.data(), {p[0], p[1], p[2]}).pixel;
               }));
}

}  // namespace slipstream::pixel_derivatives_test
