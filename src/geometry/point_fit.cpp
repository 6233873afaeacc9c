#include "geometry/point_fit.h"

#include <cmath>

#include <Eigen/SVD>

#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

using PointColumns = Eigen::Matrix<double, 3, Eigen::Dynamic>;

PointColumns columns_of(std::span<const Eigen::Vector3d> points) {
  PointColumns columns(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) {
    columns.col(static_cast<Eigen::Index>(i)) = points[i];
  }
  return columns;
}

/// The middle singular value of points on a line is 0.
void require_spread(const PointColumns& points) {
  const PointColumns centred = points.colwise() - points.rowwise().mean();
  const Eigen::Vector3d spread =
      Eigen::JacobiSVD<Eigen::Matrix3d>(centred * centred.transpose()).singularValues();
  throw_if(!(spread[1] > 1e-8 * spread[0]),
           "the points are on a line, so that their rotation about it is not determined; use "
           "three corners of a large triangle");
}

}  // namespace

PointFit fit_points(std::span<const Eigen::Vector3d> points,
                    std::span<const Eigen::Vector3d> partners) {
  throw_if(points.size() != partners.size(), "{} points have {} partners", points.size(),
           partners.size());
  throw_if(points.size() < 3, "{} pairs of points do not determine a pose; use at least 3",
           points.size());

  const PointColumns from = columns_of(points), to = columns_of(partners);
  throw_if(!from.allFinite() || !to.allFinite(), "a point has a coordinate that is not finite");
  require_spread(from);
  require_spread(to);

  PointFit fit{.pose = Eigen::Isometry3d(Eigen::umeyama(from, to, false))};
  double squares = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    fit.residuals.push_back((fit.pose * points[i] - partners[i]).norm());
    squares += fit.residuals.back() * fit.residuals.back();
  }
  fit.rms = std::sqrt(squares / static_cast<double>(points.size()));
  return fit;
}

}  // namespace slipstream
