#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/response.h"

namespace slipstream {

/// Lens distortion as in OpenCV: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tau_x tau_y; 0 if not known.
struct Distortion {
  std::array<double, 14> coefficients{};

  [[nodiscard]] bool is_zero() const;
  friend bool operator==(const Distortion&, const Distortion&) = default;
};

/// Throws Error unless there are 0, 4, 5, 8, 12 or 14 finite coefficients.
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
  double x = 0, y = 0;
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

/// What calibration knows of light and sensor; grey levels of an 8-bit camera.
struct PhotometricCalibration {
  std::optional<double> ambient{};  ///< beta of Liu 2010, Eq. (3.2), -255 to 255
  /// sigma_w^2 at half of full scale, rounding included, above 0.
  std::optional<double> noise_variance{};
  double noise_gain = 0;  ///< by which it grows with each grey level: shot noise; 0 or more
  /// Of the light to a pattern's value, projector and camera together; phases are corrected for it.
  std::optional<MeasuredResponse> response{};
  /// Of devices in colour: pictures are taken apart by it as they are read.
  std::optional<ColourMixture> colour_mixture{};

  friend bool operator==(const PhotometricCalibration&, const PhotometricCalibration&) = default;
};

/// Depths, mm, nearest first.
struct DepthRange {
  double nearest = 0, farthest = 0;

  friend bool operator==(const DepthRange&, const DepthRange&) = default;
};

/// All that calibration knows of a camera and a projector. The world is the camera's frame:
/// millimetres, X to the right and Y down in the picture, Z forward. A point X in it is at rotation
/// X + translation in the projector's frame.
struct Scanner {
  Lens camera{};
  Lens projector{};
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< mm
  PhotometricCalibration photometry{};
  /// Between which the boards stood that it was calibrated with; none where not known.
  std::optional<DepthRange> calibrated_depths{};
  std::string measured{};  ///< how and when, for people; empty where not known

  friend bool operator==(const Scanner&, const Scanner&) = default;
};

/// Whether lenses and pose are known. Sizes and photometry alone suffice for Engine::maps.
inline bool has_geometry(const Scanner& scanner) {
  return !(scanner.translation.isZero(0) && scanner.camera.intrinsic.isIdentity(0));
}

/// What is known before a calibration: the size of the camera's frames, and what else `known` says.
Scanner without_geometry(Size camera, Size projector, const PhotometricCalibration& known = {});

/// Throws Error unless both lenses are valid with a size, the rotation is one (to 1e-4), the
/// baseline is finite and not zero, photometry and depths are in range.
void require_valid(const Scanner& scanner);

/// Throws Error for ambient light, noise or gamma out of range.
void require_valid(const PhotometricCalibration& photometry);

/// sigma_w^2 at a grey level, where it is `at_half` at half of full scale. Never less than a
/// twentieth of that.
double noise_variance_at(double grey_level, double at_half, double gain);

/// The scanner with sizes that it lacks taken from the frames and the patterns, which may be empty.
/// Throws Error, naming `file`, where sizes differ, that of the projector is not known, or the
/// scanner is not valid.
Scanner completed(Scanner scanner, const std::string& file, Size camera, Size projector);

/// The scanner of two perspective matrices in one world frame, mm, up to scale: lenses without
/// distortion, perhaps with skew. Throws Error where a matrix's first three columns are singular.
Scanner scanner_of(const Eigen::Matrix<double, 3, 4>& camera, Size camera_size,
                   const Eigen::Matrix<double, 3, 4>& projector, Size projector_size);

/// Throws Error when patterns along `axis` carry no depth: the baseline runs along the stripes, so
/// that a ray meets the same stripe at every depth and Eq. (1.15) is singular.
void require_depth_visible(const Scanner& scanner, Axis axis);

/// A point of the camera's frame in the projector's.
inline Eigen::Vector3d in_projector_frame(const Scanner& scanner, const Eigen::Vector3d& point) {
  return scanner.rotation * point + scanner.translation;
}

/// Centre of the projector in the camera's frame, mm. Its length is the baseline.
inline Eigen::Vector3d projector_centre(const Scanner& scanner) {
  return -scanner.rotation.transpose() * scanner.translation;
}

/// Projector coordinate y = pixel / length, along `axis`, of a projector pixel.
inline double coordinate_along(Axis axis, const Eigen::Vector2d& pixel, Size projector) {
  return (axis == Axis::x ? pixel.x() : pixel.y()) / length_along(axis, projector);
}

}  // namespace slipstream
