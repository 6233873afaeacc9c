#include "calibrate/pixel_derivatives.h"

#include <cmath>

#include "geometry/rotation.h"

namespace slipstream {
namespace {

/// The rotation about `turn` by its length, and the further rotation by a small change of `turn`,
/// in the rotated frame.
struct Turn {
  Eigen::Matrix3d rotation;
  Eigen::Matrix3d further;
};

Turn turn_of(const Eigen::Vector3d& turn) {
  const double angle2 = turn.squaredNorm(), angle = std::sqrt(angle2);
  const bool small = angle < 1e-3;  // then the series to the second power is exact to rounding

  // Rodrigues' formula: sin / angle, (1 - cos) / angle^2 and (angle - sin) / angle^3.
  const double a = small ? 1 - angle2 / 6 : std::sin(angle) / angle;
  const double b = small ? 0.5 - angle2 / 24 : (1 - std::cos(angle)) / angle2;
  const double c = small ? 1.0 / 6 - angle2 / 120 : (1 - a) / angle2;

  const Eigen::Matrix3d K = cross_matrix(turn), K2 = K * K;
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  return {I + a * K + b * K2, I - b * K + c * K2};
}

/// Derivatives of distort_untilted.
struct DistortionSlopes {
  Eigen::Matrix2d by_direction;
  Eigen::Matrix<double, 2, untilted_coefficient_count> by_coefficients;
};

DistortionSlopes distortion_slopes(const double* k, double x, double y) {
  const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;

  const double below = 1 + k[5] * r2 + k[6] * r4 + k[7] * r6;
  const double radial = (1 + k[0] * r2 + k[1] * r4 + k[4] * r6) / below;

  // The derivative of the quotient by r^2.
  const double radial_by_r2 =
      (k[0] + 2 * k[1] * r2 + 3 * k[4] * r4 - radial * (k[5] + 2 * k[6] * r2 + 3 * k[7] * r4)) /
      below;

  const double p1 = k[2], p2 = k[3], mixed = 2 * x * y * radial_by_r2 + 2 * p1 * x + 2 * p2 * y;
  const double prism_x = k[8] + 2 * k[9] * r2, prism_y = k[10] + 2 * k[11] * r2;

  const Eigen::Vector2d direction(x, y);
  DistortionSlopes slopes;
  auto& [slope, by] = slopes;

  slope << radial + 2 * x * x * radial_by_r2 + 2 * p1 * y + 6 * p2 * x + 2 * x * prism_x,
      mixed + 2 * y * prism_x, mixed + 2 * x * prism_y,
      radial + 2 * y * y * radial_by_r2 + 6 * p1 * y + 2 * p2 * x + 2 * y * prism_y;

  // In OpenCV's order: k1 k2 p1 p2 k3, the denominator's k4 k5 k6, s1 s2 s3 s4.
  by.col(0) = direction * r2 / below;
  by.col(1) = direction * r4 / below;
  by.col(2) = Eigen::Vector2d(2 * x * y, r2 + 2 * y * y);
  by.col(3) = Eigen::Vector2d(r2 + 2 * x * x, 2 * x * y);
  by.col(4) = direction * r6 / below;
  by.col(5) = -radial * by.col(0);
  by.col(6) = -radial * by.col(1);
  by.col(7) = -radial * by.col(4);
  by.col(8) = Eigen::Vector2d(r2, 0);
  by.col(9) = Eigen::Vector2d(r4, 0);
  by.col(10) = Eigen::Vector2d(0, r2);
  by.col(11) = Eigen::Vector2d(0, r4);

  return slopes;
}

}  // namespace

MovedPoint moved_point(const double* pose, const Eigen::Vector3d& point) {
  const auto [rotation, further] = turn_of(Eigen::Map<const Eigen::Vector3d>(pose));

  MovedPoint moved;
  moved.point = rotation * point + Eigen::Map<const Eigen::Vector3d>(pose + 3);
  moved.by_pose << -rotation * cross_matrix(point) * further, Eigen::Matrix3d::Identity();
  moved.by_point = rotation;

  return moved;
}

SeenPoint seen_point(const double* lens, const Eigen::Vector3d& point) {
  const double* k = lens + 4;
  const double x = point.x() / point.z(), y = point.y() / point.z();

  const Eigen::Vector2d bent = distort_untilted<double>(k, Eigen::Vector2d(x, y));
  const Eigen::Vector2d focal(lens[0], lens[1]);
  const DistortionSlopes slopes = distortion_slopes(k, x, y);

  SeenPoint seen;
  seen.pixel = focal.cwiseProduct(bent) + Eigen::Vector2d(lens[2], lens[3]);
  seen.by_lens << Eigen::Matrix2d(bent.asDiagonal()), Eigen::Matrix2d::Identity(),
      focal.asDiagonal() * slopes.by_coefficients;

  // By the chain rule: perspective division, distortion, focal length.
  Eigen::Matrix<double, 2, 3> direction_by_point;
  direction_by_point << 1, 0, -x, 0, 1, -y;
  seen.by_point = focal.asDiagonal() * slopes.by_direction * (direction_by_point / point.z());

  return seen;
}

}  // namespace slipstream
