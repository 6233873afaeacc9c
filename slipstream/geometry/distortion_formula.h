#pragma once

#include <Eigen/Core>

namespace slipstream {

/// Coefficients of a lens without the tilt of its sensor: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4.
inline constexpr int untilted_coefficient_count = 12;

/// Where the direction (u, v, 1) passes after a lens whose sensor is not tilted, in normalised
/// coordinates: OpenCV's model, for any number type that may carry derivatives. `k` points to
/// untilted_coefficient_count coefficients.
template <class Number, class Coefficient>
Eigen::Matrix<Number, 2, 1> distort_untilted(const Coefficient* k,
                                             const Eigen::Matrix<Number, 2, 1>& direction) {
  const Coefficient &k1 = k[0], &k2 = k[1], &p1 = k[2], &p2 = k[3], &k3 = k[4], &k4 = k[5];
  const Coefficient &k5 = k[6], &k6 = k[7], &s1 = k[8], &s2 = k[9], &s3 = k[10], &s4 = k[11];
  const Number x = direction.x();
  const Number y = direction.y();
  const Number r2 = x * x + y * y;
  const Number r4 = r2 * r2;
  const Number r6 = r4 * r2;
  const Number radial = (1.0 + k1 * r2 + k2 * r4 + k3 * r6) / (1.0 + k4 * r2 + k5 * r4 + k6 * r6);
  return {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + s1 * r2 + s2 * r4,
          y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + s3 * r2 + s4 * r4};
}

}  // namespace slipstream
