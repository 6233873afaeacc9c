#pragma once

#include <array>
#include <span>
#include <string_view>

#include <Eigen/Core>

#include "slipstream/base/image.h"
#include "slipstream/base/size.h"

namespace slipstream {

/// Lens distortion as in OpenCV: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tau_x tau_y; what a
/// calibration does not have is 0.
struct Distortion {
  std::array<double, 14> coefficients{};

  [[nodiscard]] bool is_zero() const;
  friend bool operator==(const Distortion&, const Distortion&) = default;
};

/// From 0, 4, 5, 8, 12 or 14 coefficients; throws Error for another number of them or for one that
/// is not finite.
Distortion make_distortion(std::span<const double> coefficients);

/// A camera, or a projector seen as a camera: a ray with direction (u, v, 1) in the device's frame
/// meets pixel K distort(u, v). Pixel centres are at integers.
struct Lens {
  Eigen::Matrix3d intrinsic = Eigen::Matrix3d::Identity();  ///< K, pixels
  Distortion distortion;
  Size size;  ///< the device's pixels; empty where the calibration does not say

  friend bool operator==(const Lens&, const Lens&) = default;
};

/// Throws Error, naming the device, unless K is finite, upper triangular with positive focal
/// lengths and 1 at its end.
void require_valid(const Lens& lens, std::string_view device);

/// Where the direction (u, v, 1) passes after the lens, in normalised coordinates.
Eigen::Vector2d distort(const Distortion& distortion, const Eigen::Vector2d& direction);

/// The inverse of distort, to rounding. NaN where the model folds over and has no inverse.
Eigen::Vector2d undistort(const Distortion& distortion, const Eigen::Vector2d& distorted);

/// Pixel at which the device sees, or lights, a point in its own frame (Z > 0).
Eigen::Vector2d project(const Lens& lens, const Eigen::Vector3d& point);

/// Direction (u, v, 1) of the ray through a pixel, in the device's frame.
Eigen::Vector3d ray_through(const Lens& lens, const Eigen::Vector2d& pixel);

/// A place in a picture, in pixels.
struct PixelPosition {
  double x = 0;
  double y = 0;
};

/// For every pixel, where it would be if the lens had no distortion: x^c, y^c of Liu 2010, Eqs.
/// (1.11), (1.12). NaN where the lens model has no inverse.
Image<PixelPosition> undistorted_pixels(const Lens& lens);

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
