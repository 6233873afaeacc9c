#pragma once

#include <Eigen/Core>

#include "slipstream/scanner.h"

namespace slipstream {

/// fx fy cx cy and the distortion coefficients.
inline constexpr int lens_number_count = 4 + untilted_coefficient_count;

/// A point moved by a pose (axis times angle, translation), with its derivatives by both.
struct MovedPoint {
  Eigen::Vector3d point;
  Eigen::Matrix<double, 3, 6, Eigen::RowMajor> by_pose;
  Eigen::Matrix3d by_point;
};

/// `pose` points to 6 numbers.
MovedPoint moved_point(const double* pose, const Eigen::Vector3d& point);

/// The pixel of a point in the device's frame, with its derivatives by lens and point.
struct SeenPoint {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, lens_number_count, Eigen::RowMajor> by_lens;
  Eigen::Matrix<double, 2, 3, Eigen::RowMajor> by_point;
};

/// `lens` points to lens_number_count numbers.
SeenPoint seen_point(const double* lens, const Eigen::Vector3d& point);

}  // namespace slipstream
