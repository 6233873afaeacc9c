#include "cloud/plane_frame.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/LU>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "geometry/rotation.h"

namespace slipstream {
namespace {

constexpr double least_angle = 20 * degree;

/// Angle between two planes, 0 to a right angle.
double angle_of(const FittedPlane& first, const FittedPlane& second) {
  return std::acos(std::min(std::abs(first.normal.dot(second.normal)), 1.0));
}

}  // namespace

PlaneFrame frame_of_planes(const std::array<FittedPlane, 3>& planes) {
  const auto& [first, second, third] = planes;

  // 1. The planes must be well inclined to each other.
  PlaneFrame frame;
  const std::array<std::array<int, 2>, 3> pairs{{{0, 1}, {0, 2}, {1, 2}}};
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [a, b] = pairs[i];
    const double angle = angle_of(planes[a], planes[b]);
    throw_if(angle < least_angle,
             "planes {} and {} are {:.1f} degrees from parallel; three faces of a corner are "
             "needed, at least {:.0f} degrees apart",
             a + 1, b + 1, angle / degree, least_angle / degree);
    frame.off_square[i] = std::asin(std::clamp(planes[a].normal.dot(planes[b].normal), -1.0, 1.0));
  }

  // 2. Where they meet.
  Eigen::Matrix3d normals;
  normals << first.normal.transpose(), second.normal.transpose(), third.normal.transpose();
  throw_if(std::abs(normals.determinant()) < std::sin(least_angle) * std::sin(least_angle),
           "the three planes nearly share a line, so that they meet in no definite point; use "
           "three faces of a corner");
  const Eigen::Vector3d offsets(first.normal.dot(first.centre), second.normal.dot(second.centre),
                                third.normal.dot(third.centre));
  const Eigen::Vector3d origin = normals.inverse() * offsets;

  // 3. The axes, as rows of the rotation into the new frame.
  const Eigen::Vector3d z = first.normal;
  const Eigen::Vector3d y = (second.normal - second.normal.dot(z) * z).normalized();
  Eigen::Matrix3d turn;
  turn << y.cross(z).transpose(), y.transpose(), z.transpose();

  frame.pose = pose_from(turn, -turn * origin);
  return frame;
}

}  // namespace slipstream
