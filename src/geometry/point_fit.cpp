#include "geometry/point_fit.h"

#include <Eigen/SVD>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "geometry/rotation.h"

namespace slipstream {
namespace {

Eigen::Matrix3Xd columns_of(std::span<const Eigen::Vector3d> points) {
  Eigen::Matrix3Xd columns(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  return columns;
}

/// The middle singular value of points on a line is 0.
void require_spread(const Eigen::Matrix3Xd& points) {
  const Eigen::Matrix3Xd centred = points.colwise() - points.rowwise().mean();
  const Eigen::Vector3d spread =
      Eigen::JacobiSVD<Eigen::Matrix3d>(centred * centred.transpose()).singularValues();
  throw_if(!(spread[1] > 1e-8 * spread[0]),
           "the points are on a line, so that their rotation about it is not determined; use "
           "three corners of a large triangle");
}

}  // namespace

Eigen::Isometry3d motion_between_points(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to) {
  return Eigen::Isometry3d(Eigen::umeyama(from, to, false));
}

PointFit fit_points(std::span<const Eigen::Vector3d> points,
                    std::span<const Eigen::Vector3d> partners) {
  throw_if(points.size() != partners.size(), "{} points have {} partners", points.size(),
           partners.size());
  throw_if(points.size() < 3, "{} pairs of points do not determine a pose; use at least 3",
           points.size());

  const Eigen::Matrix3Xd from = columns_of(points), to = columns_of(partners);
  throw_if(!from.allFinite() || !to.allFinite(), "a point has a coordinate that is not finite");
  require_spread(from);
  require_spread(to);

  PointFit fit{.pose = motion_between_points(from, to)};
  Squares distances;
  for (std::size_t i = 0; i < points.size(); ++i) {
    fit.residuals.push_back((fit.pose * points[i] - partners[i]).norm());
    distances.add(fit.residuals.back() * fit.residuals.back());
  }
  fit.rms = distances.rms();
  return fit;
}

Vector6 known_step(const Matrix6& squares, const Vector6& right) {
  constexpr double least_known = 1e-4;  // of the best known direction

  const PrincipalAxes axes = principal_axes(squares);
  Vector6 step = Vector6::Zero();
  for (int i = 0; i < 6; ++i) {
    if (!(axes.values(i) > least_known * axes.values(5))) continue;
    const auto axis = axes.vectors.col(i);
    step += axis.dot(right) / axes.values(i) * axis;
  }
  return step;
}

Eigen::Isometry3d motion_about(const Eigen::Vector3d& centre, const Vector6& step) {
  const Eigen::Vector3d turn = step.head<3>();
  const Eigen::Matrix3d rotation =
      turn.norm() > 0 ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                      : Eigen::Matrix3d::Identity();
  return pose_from(rotation, centre + step.tail<3>() - rotation * centre);
}

}  // namespace slipstream
