#pragma once

#include <cmath>

#include <Eigen/Core>

#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// X, Y, Z of a pixel, mm; NaN where it has no point.
inline Eigen::Vector3d position_at(const Cloud& cloud, int column, int row) {
  return {cloud.x(column, row), cloud.y(column, row), cloud.z(column, row)};
}

/// Whether two points of neighbouring pixels lie on one surface: their depths differ by at most
/// `largest_step` times the distance between their rays at the depth of the first. False where one
/// is missing.
inline bool on_one_surface(const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                           double largest_step) {
  // Between the rays, and not the points: off the axis a jump in depth moves a point sideways too.
  const double across =
      first.z() * (second.head<2>() / second.z() - first.head<2>() / first.z()).norm();
  return std::abs(second.z() - first.z()) <= largest_step * across;
}

}  // namespace slipstream
