#pragma once

#include <span>
#include <vector>

#include <Eigen/Geometry>

namespace slipstream {

/// Least-squares motion of points, a column for each, to their partners, without a change of scale
/// (Umeyama 1991).
Eigen::Isometry3d motion_between_points(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

/// The rigid motion that maps points onto others, and how well.
struct PointFit {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  std::vector<double> residuals{};  ///< distance of each mapped point from its partner, mm
  double rms = 0;                   ///< of the residuals, mm
};

/// The motion between points and their partners in the same order. Throws Error unless there are as
/// many partners as points, at least three, all finite, and the points are not on a line.
PointFit fit_points(std::span<const Eigen::Vector3d> points,
                    std::span<const Eigen::Vector3d> partners);

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Solves the normal equations `squares` * step = `right`; reads the lower triangle of `squares`.
/// The step is 0 along eigenvectors that the data leave open, with less than 1e-4 of the largest
/// eigenvalue. Give turn and shift similar units.
Vector6 known_step(const Matrix6& squares, const Vector6& right);

/// The motion about `centre` of a turn (axis times angle, rad) and a shift (mm).
Eigen::Isometry3d motion_about(const Eigen::Vector3d& centre, const Vector6& step);

}  // namespace slipstream
