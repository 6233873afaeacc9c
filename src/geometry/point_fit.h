#pragma once

#include <span>
#include <vector>

#include <Eigen/Geometry>

namespace slipstream {

/// The rigid motion that maps points onto others, and how well.
struct PointFit {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  std::vector<double> residuals{};  ///< distance of each mapped point from its partner, mm
  double rms = 0;                   ///< of the residuals, mm
};

/// Least-squares motion of points to their partners in the same order, without a change of scale
/// (Umeyama 1991). Throws Error unless there are as many partners as points, at least three, all
/// finite, and the points are not on a line.
PointFit fit_points(std::span<const Eigen::Vector3d> points,
                    std::span<const Eigen::Vector3d> partners);

}  // namespace slipstream
