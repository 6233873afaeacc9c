#include "slipstream/geometry/lens.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fmt/format.h>
#include <unsupported/Eigen/AutoDiff>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/base/parallel_rows.h"

namespace slipstream {
namespace {

template <class Number>
using Vector2 = Eigen::Matrix<Number, 2, 1>;

/// Projection onto a sensor tilted by tau_x, tau_y (OpenCV's last two coefficients).
Eigen::Matrix3d tilt_matrix(double tau_x, double tau_y) {
  const Eigen::Matrix3d R = (Eigen::AngleAxisd(-tau_y, Eigen::Vector3d::UnitY()) *
                             Eigen::AngleAxisd(-tau_x, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix();
  Eigen::Matrix3d onto_sensor;
  onto_sensor << R(2, 2), 0, -R(0, 2), 0, R(2, 2), -R(1, 2), 0, 0, 1;
  return onto_sensor * R;
}

template <class Number>
Vector2<Number> distort_generic(const Distortion& distortion, const Vector2<Number>& direction) {
  const double tau_x = distortion.coefficients[12], tau_y = distortion.coefficients[13];
  const Vector2<Number> bent = distort_untilted(distortion.coefficients.data(), direction);
  if (tau_x == 0 && tau_y == 0) return bent;

  const Eigen::Matrix3d tilt = tilt_matrix(tau_x, tau_y);
  const auto row = [&](int i) -> Number {
    return tilt(i, 0) * bent.x() + tilt(i, 1) * bent.y() + tilt(i, 2);
  };
  const Number depth = row(2);
  return {row(0) / depth, row(1) / depth};
}

}  // namespace

bool Distortion::is_zero() const {
  return std::all_of(coefficients.begin(), coefficients.end(), [](double k) { return k == 0; });
}

Distortion make_distortion(std::span<const double> coefficients) {
  constexpr std::array<std::size_t, 6> known_counts{0, 4, 5, 8, 12, 14};
  if (std::find(known_counts.begin(), known_counts.end(), coefficients.size()) ==
      known_counts.end()) {
    throw Error(fmt::format("{} distortion coefficients; there are 0, 4, 5, 8, 12 or 14",
                            coefficients.size()));
  }
  Distortion distortion;
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    if (!std::isfinite(coefficients[i])) {
      throw Error(
          fmt::format("distortion coefficient {} is {}; it must be finite", i, coefficients[i]));
    }
    distortion.coefficients[i] = coefficients[i];
  }
  return distortion;
}

void require_valid(const Lens& lens, std::string_view device) {
  const Eigen::Matrix3d& K = lens.intrinsic;
  const bool camera_matrix = K.allFinite() && K(0, 0) > 0 && K(1, 1) > 0 && K(1, 0) == 0 &&
                             K(2, 0) == 0 && K(2, 1) == 0 && K(2, 2) == 1;
  if (!camera_matrix) {
    throw Error(fmt::format(
        "{}: the camera matrix is not one; its form is [fx s cx; 0 fy cy; 0 0 1], fx, fy > 0",
        device));
  }
}

Eigen::Vector2d distort(const Distortion& distortion, const Eigen::Vector2d& direction) {
  return distort_generic<double>(distortion, direction);
}

Eigen::Vector2d undistort(const Distortion& distortion, const Eigen::Vector2d& distorted) {
  if (distortion.is_zero()) return distorted;
  using Dual = Eigen::AutoDiffScalar<Eigen::Vector2d>;
  constexpr int most_iterations = 30;
  constexpr double tolerance = 1e-15;

  Eigen::Vector2d direction = distorted;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const Vector2<Dual> variables(Dual(direction.x(), 2, 0), Dual(direction.y(), 2, 1));
    const Vector2<Dual> bent = distort_generic<Dual>(distortion, variables);
    Eigen::Matrix2d jacobian;
    jacobian << bent.x().derivatives().transpose(), bent.y().derivatives().transpose();
    if (!(jacobian.determinant() > 0)) return {nan, nan};
    const Eigen::Vector2d residual(bent.x().value() - distorted.x(),
                                   bent.y().value() - distorted.y());
    const Eigen::Vector2d step = jacobian.inverse() * residual;
    direction -= step;
    if (step.lpNorm<Eigen::Infinity>() <= tolerance * (1 + direction.lpNorm<Eigen::Infinity>())) {
      return direction;
    }
  }
  return {nan, nan};
}

Eigen::Vector2d project(const Lens& lens, const Eigen::Vector3d& point) {
  const Eigen::Vector2d bent = distort(lens.distortion, point.hnormalized());
  return (lens.intrinsic * bent.homogeneous()).head<2>();
}

Eigen::Vector3d ray_through(const Lens& lens, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d bent =
      lens.intrinsic.triangularView<Eigen::Upper>().solve(pixel.homogeneous()).head<2>();
  return undistort(lens.distortion, bent).homogeneous();
}

Image<PixelPosition> undistorted_pixels(const Lens& lens) {
  Image<PixelPosition> positions(lens.size);
  for_each_pixel(lens.size, [&](int column, int row) {
    const Eigen::Vector3d ideal = lens.intrinsic * ray_through(lens, {column, row});
    positions(column, row) = {ideal.x(), ideal.y()};
  });
  return positions;
}

}  // namespace slipstream
