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

}  // namespace slipstream
