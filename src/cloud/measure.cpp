#include "slipstream/measure.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <random>
#include <string_view>

#include <Eigen/Geometry>
#include <Eigen/QR>

#include "base/linear_algebra.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

using Vector = Eigen::Vector3d;
using Points = std::vector<MeasuredPoint>;

/// Displacement of a point along its ray by one standard deviation of the noise.
Vector moved_by_noise(const MeasuredPoint& point) {
  return point.position * (point.sigma->z() / point.position.z());
}

Vector normal_at(const FittedPlane& plane, const Vector& /*point*/) {
  return plane.normal;
}
Vector normal_at(const FittedSphere& sphere, const Vector& point) {
  return (point - sphere.centre).normalized();
}

Vector mean_of(std::span<const MeasuredPoint> points) {
  Vector sum = Vector::Zero();

  for (const MeasuredPoint& point : points) sum += point.position;

  return sum / static_cast<double>(points.size());
}

/// The least-squares plane; ignores the plane near it.
FittedPlane plane_of(std::span<const MeasuredPoint> points, const FittedPlane& /*near*/) {
  FittedPlane plane{.centre = mean_of(points)};
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const MeasuredPoint& point : points) {
    const Vector offset = point.position - plane.centre;
    scatter += offset * offset.transpose();
  }

  // The normal is the axis of least scatter. On a line the second axis has none either.
  const PrincipalAxes axes = principal_axes(scatter);
  throw_if(!(axes.values(1) > 1e-9 * axes.values(2)),
           "the points lie on a line and do not determine a plane");
  plane.normal = axes.vectors.col(0);
  if (plane.normal.dot(plane.centre) > 0) plane.normal = -plane.normal;

  return plane;
}

/// The sphere by linear least squares of |p|^2 = 2 c p + k, relative to the points' mean.
FittedSphere rough_sphere_of(std::span<const MeasuredPoint> points) {
  const Vector mean = mean_of(points);

  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();

  for (const MeasuredPoint& point : points) {
    const Vector offset = point.position - mean;
    const Eigen::Vector4d row = (2 * offset).homogeneous();
    normal += row * row.transpose();
    right += row * offset.squaredNorm();
  }

  const Eigen::Vector4d solved = solve_symmetric(normal, right);
  const Vector centre = solved.head<3>();
  return {.centre = mean + centre, .radius = std::sqrt(solved(3) + centre.squaredNorm())};
}

constexpr std::size_t least_of_plane = 3, least_of_sphere = 4;

void require_points(std::span<const MeasuredPoint> points, std::size_t least,
                    std::string_view shape) {
  throw_if(points.size() < least, "too few points for a {}: {} of at least {}", shape,
           points.size(), least);
}

/// The least-squares sphere by Gauss-Newton, starting from one near it. On a nearly flat patch the
/// normals differ too little for normal equations to determine the radius, so it uses QR.
FittedSphere sphere_of(std::span<const MeasuredPoint> points, FittedSphere sphere) {
  constexpr int most_steps = 50;

  require_points(points, least_of_sphere, "sphere");

  const auto count = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixX4d rows(count, 4);
  Eigen::VectorXd residuals(count);
  Eigen::HouseholderQR<Eigen::MatrixX4d> solver;

  // Gauss-Newton: a residual changes with the centre along the normal, and with the radius.
  for (int i = 0; i < most_steps; ++i) {
    for (Eigen::Index k = 0; k < count; ++k) {
      const Vector& point = points[static_cast<std::size_t>(k)].position;
      rows.row(k) = normal_at(sphere, point).homogeneous();
      residuals(k) = signed_distance(sphere, point);
    }

    const Eigen::Vector4d step = solver.compute(rows).solve(residuals);
    sphere.centre += step.head<3>();
    sphere.radius += step(3);
    if (!(step.norm() > 1e-10 * sphere.radius)) break;
  }

  // Standard deviation of the radius, from the residuals and R of the QR decomposition.
  const double freedom = std::max(static_cast<double>(count) - 4, 1.0);
  const double to_radius = std::abs(solver.matrixQR()(3, 3));  // the radius is the last unknown
  sphere.radius_sigma = residuals.norm() / std::sqrt(freedom) / to_radius;

  // Points on a plane have a random radius, so require five standard deviations. A radius far
  // larger than their extent is lost in rounding.
  const double extent = (points.front().position - points.back().position).norm();
  throw_if(!(5 * sphere.radius_sigma < sphere.radius && sphere.radius < 1e4 * extent),
           "the points are too flat to determine the radius of a sphere");

  return sphere;
}

/// The least-squares sphere with the radius of the one near it.
FittedSphere centred_sphere_of(std::span<const MeasuredPoint> points, FittedSphere sphere) {
  constexpr int most_steps = 20;

  for (int i = 0; i < most_steps; ++i) {
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Vector right = Vector::Zero();

    for (const MeasuredPoint& point : points) {
      const Vector normal = normal_at(sphere, point.position);
      squares += normal * normal.transpose();
      right += signed_distance(sphere, point.position) * normal;
    }

    const Vector step = solve_symmetric(squares, right);
    sphere.centre += step;
    if (!(step.norm() > 1e-9 * sphere.radius)) break;
  }

  return sphere;
}

/// The distance quantile of all points, or of a limited number in equal steps.
template <class Shape>
double distance_of_share(const Shape& shape, std::span<const MeasuredPoint> points, double share,
                         std::size_t most_looked_at = std::numeric_limits<std::size_t>::max()) {
  std::vector<double> distances;

  const std::size_t step = std::max<std::size_t>(points.size() / most_looked_at, 1);
  for (std::size_t i = 0; i < points.size(); i += step) {
    distances.push_back(std::abs(signed_distance(shape, points[i].position)));
  }

  // Unsuitable points give a shape of NaN.
  if (!std::isfinite(distances.front())) return std::numeric_limits<double>::infinity();
  return quantile(distances, share);
}

/// The shape of least median distance among shapes through `drawn` random points. With a third of
/// outliers, all of 200 draws of 6 points contain one with a probability of 10^-8.
template <class Shape, class Through>
Shape least_median_shape(std::span<const MeasuredPoint> points, std::size_t drawn,
                         const Through& through) {
  constexpr int draws = 200;
  constexpr std::size_t most_looked_at = 1000;

  std::mt19937 random(1);
  Shape best = through(points);
  double least = distance_of_share(best, points, 0.5, most_looked_at);

  for (int draw = 0; draw < draws; ++draw) {
    Points few;
    for (std::size_t i = 0; i < drawn; ++i) few.push_back(points[random() % points.size()]);

    const Shape shape = through(few);
    const double median = distance_of_share(shape, points, 0.5, most_looked_at);
    if (median < least) {
      least = median;
      best = shape;
    }
  }

  return best;
}

template <class Shape>
Residuals residuals_of(const Shape& shape, const Points& used, std::size_t outliers) {
  Residuals residuals{.points = used.size(), .outliers = outliers};

  Squares distances, noise;
  for (const MeasuredPoint& point : used) {
    const double distance = signed_distance(shape, point.position);
    residuals.largest = std::max(residuals.largest, std::abs(distance));
    distances.add(distance * distance);

    // One point without a standard deviation makes the sum NaN.
    const Vector normal = normal_at(shape, point.position);
    noise.add(point.sigma ? std::pow(normal.dot(moved_by_noise(point)), 2)
                          : std::numeric_limits<double>::quiet_NaN());
  }

  residuals.rms = distances.rms();
  if (std::isfinite(noise.sum)) residuals.noise = noise.rms();
  return residuals;
}

/// The least-squares shape of the points near a robust one, iterated until these no longer change.
/// Near: up to `times` the quantile `share` of all distances, by default four standard deviations,
/// as the median of Gaussian distances is sigma / 1.4826.
template <class Shape, class Fit>
Shape fit_near(std::span<const MeasuredPoint> points, Shape shape, const Fit& fit,
               double share = 0.5, double times = 4 * 1.4826) {
  constexpr int most_rounds = 20;

  Points used;
  for (int round = 0; round < most_rounds; ++round) {
    // Choose the points near the shape, and fit it to them.
    const double farthest = times * distance_of_share(shape, points, share);
    Points near;
    std::copy_if(points.begin(), points.end(), std::back_inserter(near), [&](const auto& point) {
      return std::abs(signed_distance(shape, point.position)) <= farthest;
    });

    const bool settled = near.size() == used.size();
    used = std::move(near);
    shape = fit(used, shape);
    if (settled) break;
  }

  shape.residuals = residuals_of(shape, used, points.size() - used.size());
  return shape;
}

/// Fits without outliers, or without the share `left_out`.
template <class Shape, class Fit>
Shape robust_fit(std::span<const MeasuredPoint> points, const Shape& rough, const Fit& fit,
                 std::optional<double> left_out) {
  const Shape shape = fit_near(points, rough, fit);
  return left_out ? fit_near(points, shape, fit, 1 - *left_out, 1) : shape;
}

}  // namespace

std::optional<MeasuredPoint> point_at(const Cloud& cloud, const Uncertainty* uncertainty,
                                      int column, int row) {
  const Size size = cloud.size();
  if (column < 0 || row < 0 || column >= size.width || row >= size.height) return std::nullopt;
  if (cloud.validity(column, row) != Validity::valid) return std::nullopt;

  MeasuredPoint point{position_at(cloud, column, row)};
  if (uncertainty != nullptr && std::isfinite(uncertainty->z(column, row))) {
    point.sigma = Vector(uncertainty->x(column, row), uncertainty->y(column, row),
                         uncertainty->z(column, row));
  }

  return point;
}

std::vector<MeasuredPoint> points_in(const Cloud& cloud, const Uncertainty* uncertainty,
                                     std::optional<Rectangle> rectangle) {
  Points points;

  const auto [x, y, size] = rectangle.value_or(Rectangle{0, 0, cloud.size()});
  const int bottom = y + std::min(size.height, cloud.size().height - y);
  const int right = x + std::min(size.width, cloud.size().width - x);

  for (int row = y; row < bottom; ++row) {
    for (int column = x; column < right; ++column) {
      if (const auto point = point_at(cloud, uncertainty, column, row)) points.push_back(*point);
    }
  }

  return points;
}

Distance distance(const MeasuredPoint& from, const MeasuredPoint& to) {
  const Vector difference = to.position - from.position;
  Distance result{.length = difference.norm()};

  // Only noise along the line between them changes the distance.
  if (from.sigma && to.sigma) {
    const Vector along = difference.normalized();
    result.sigma = std::hypot(along.dot(moved_by_noise(from)), along.dot(moved_by_noise(to)));
  }

  return result;
}

double signed_distance(const FittedPlane& plane, const Vector& point) {
  return plane.normal.dot(point - plane.centre);
}

double signed_distance(const FittedSphere& sphere, const Vector& point) {
  return (point - sphere.centre).norm() - sphere.radius;
}

FittedPlane fit_plane(std::span<const MeasuredPoint> points, std::optional<double> left_out) {
  require_points(points, least_of_plane, "plane");

  const auto through = [](std::span<const MeasuredPoint> few) {
    const Vector first = few[0].position;
    const Vector normal = (few[1].position - first).cross(few[2].position - first);
    return FittedPlane{.normal = normal / normal.norm(), .centre = first};
  };

  return robust_fit(points, least_median_shape<FittedPlane>(points, least_of_plane, through),
                    plane_of, left_out);
}

FittedSphere fit_sphere(std::span<const MeasuredPoint> points, std::optional<double> left_out) {
  constexpr std::size_t drawn = 6;

  require_points(points, least_of_sphere, "sphere");
  return robust_fit(points, least_median_shape<FittedSphere>(points, drawn, rough_sphere_of),
                    sphere_of, left_out);
}

FittedSphere fit_sphere_near(std::span<const MeasuredPoint> points, const FittedSphere& near) {
  require_points(points, least_of_sphere, "sphere");
  return fit_near(points, near, centred_sphere_of);
}

}  // namespace slipstream
