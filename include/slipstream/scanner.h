#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slipstream/image.h"
#include "slipstream/pattern_set.h"
#include "slipstream/response.h"
#include "slipstream/setting.h"

namespace slipstream {

/// Lens distortion as in OpenCV: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 tau_x tau_y; 0 if unknown.
struct Distortion {
  std::array<double, 14> coefficients{};

  [[nodiscard]] bool is_zero() const { return *this == Distortion{}; }
  friend bool operator==(const Distortion&, const Distortion&) = default;
};

/// Throws Error unless there are 0, 4, 5, 8, 12 or 14 finite coefficients.
Distortion make_distortion(std::span<const double> coefficients);

/// The remainder of a lens model: a smooth shift of its pixels, as sums of Chebyshev polynomials
/// T_i(a) T_j(b), i + j <= degree, of the place (a, b) = (pixel - centre) / half.
struct LensResidual {
  static constexpr int largest_degree = 14;

  Eigen::Vector2d centre = {0, 0}, half = {1, 1};  ///< of the picture, pixels
  /// Coefficients of x and y, pixels: c_00 c_01 ... c_0d c_10 ... c_d0; empty without a map.
  std::vector<Eigen::Vector2d> terms{};

  friend bool operator==(const LensResidual&, const LensResidual&) = default;
};

/// The shift of a pixel, pixels; 0 without a map.
Eigen::Vector2d shift_at(const LensResidual& residual, const Eigen::Vector2d& pixel);

/// A camera, or a projector as an inverse camera: a ray with direction (u, v, 1) in the device's
/// frame meets the pixel that its residual shifts from K distort(u, v). Pixel centres are at
/// integers.
struct Lens {
  Eigen::Matrix3d intrinsic = Eigen::Matrix3d::Identity();  ///< K, pixels
  Distortion distortion;
  Size size;  ///< of the device, pixels; 0x0 without a calibrated size
  LensResidual residual{};

  friend bool operator==(const Lens&, const Lens&) = default;
};

/// Whether K alone describes the lens.
inline bool is_straight(const Lens& lens) {
  return lens.distortion.is_zero() && lens.residual.terms.empty();
}

/// The lens for pictures that show only this part of its own. Throws Error unless the part lies
/// inside of them, where their size is known.
Lens part_of(Lens lens, const Rectangle& part);

/// Throws Error, beginning with the device, unless K is finite and upper triangular, with positive
/// focal lengths and K(2, 2) = 1, and the residual has all terms of its degree.
void require_valid(const Lens& lens, std::string_view device);

/// Projection onto a sensor tilted by tau_x, tau_y.
Eigen::Matrix3d sensor_tilt(double tau_x, double tau_y);

/// The image of direction (u, v, 1) after the lens, in normalised coordinates.
Eigen::Vector2d distort(const Distortion& distortion, const Eigen::Vector2d& direction);

/// The inverse of distort, to rounding. NaN where the model is not invertible.
Eigen::Vector2d undistort(const Distortion& distortion, const Eigen::Vector2d& distorted);

/// The largest tangent of a direction's angle to the axis whose image lies in the picture, or past
/// its ends by the share `margin` of its width and height; a little more, or the tangent beside the
/// picture if the axis is there. Nullopt if the lens model turns back before: there, several
/// directions have one image.
std::optional<double> largest_tangent(const Lens& lens, const Eigen::Vector2d& margin = {0, 0});

/// Pixel at which the device sees, or illuminates, a point in its own frame (Z > 0).
Eigen::Vector2d project(const Lens& lens, const Eigen::Vector3d& point);

/// Direction (u, v, 1) of the ray through a pixel, in the device's frame.
Eigen::Vector3d ray_through(const Lens& lens, const Eigen::Vector2d& pixel);

/// A position in an image, pixels.
struct PixelPosition {
  double x = 0, y = 0;
};

/// The undistorted position of every pixel: x^c, y^c of Liu 2010, Eqs. (1.11), (1.12). NaN where
/// the lens model is not invertible.
Image<PixelPosition> undistorted_pixels(const Lens& lens);

/// Coefficients of a lens without sensor tilt: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4.
inline constexpr int untilted_coefficient_count = 12;

/// The image of direction (u, v, 1) after a lens without sensor tilt, in normalised coordinates:
/// OpenCV's model, for any number type, also with derivatives. `k` points to
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

  const Number one(1), two(2);
  const Number radial = (one + k1 * r2 + k2 * r4 + k3 * r6) / (one + k4 * r2 + k5 * r4 + k6 * r6);

  return {x * radial + two * p1 * x * y + p2 * (r2 + two * x * x) + s1 * r2 + s2 * r4,
          y * radial + p1 * (r2 + two * y * y) + two * p2 * x * y + s3 * r2 + s4 * r4};
}

/// Photometric calibration of light and sensor; grey levels of an 8-bit camera.
struct PhotometricCalibration {
  std::optional<double> ambient{};  ///< beta of Liu 2010, Eq. (3.2)
  /// sigma_w^2 at half of full scale, including rounding.
  std::optional<double> noise_variance{};
  double noise_gain = 0;  ///< increase per grey level, from shot noise

  /// From pattern value to light, projector and camera combined; phases are corrected for it.
  std::optional<MeasuredResponse> response{};
  /// For colour devices: used to separate pictures when they are read.
  std::optional<ColourMixture> colour_mixture{};
  /// Factors of red, green and blue that make a grey surface grey; the least is 1.
  std::optional<std::array<double, 3>> white_balance{};

  /// The numbers, named as in scanner files.
  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit({"ambient_light", "ambient-light",
           "ambient light, grey levels of 255; default: from the scanner file", "grey levels", -255,
           255},
          self.ambient);
    visit({"noise_variance", "noise-variance",
           "noise variance sigma_w^2, squared grey levels of 255; default: from the scanner file",
           "grey levels^2", 0, 255 * 255, /*above_least=*/true},
          self.noise_variance);
    visit({.name = "noise_gain", .least = 0, .most = 255}, self.noise_gain);
  }

  friend bool operator==(const PhotometricCalibration&, const PhotometricCalibration&) = default;
};

/// Depths, mm, nearest first.
struct DepthRange {
  double nearest = 0, farthest = 0;

  friend bool operator==(const DepthRange&, const DepthRange&) = default;
};

/// Calibration of a camera and a projector. World coordinates are in the camera's frame:
/// millimetres, X right and Y down in the image, Z forward. A point X has position rotation X +
/// translation in the projector's frame.
struct Scanner {
  Lens camera{};
  Lens projector{};
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< mm

  PhotometricCalibration photometry{};
  /// Depth range of the calibration boards; nullopt if unknown.
  std::optional<DepthRange> calibrated_depths{};
  double calibration_rms = 0;  ///< reprojection error of both devices, pixels; 0 if unknown
  std::string measured{};      ///< how and when, for the user; optional

  friend bool operator==(const Scanner&, const Scanner&) = default;
};

/// Whether lenses and pose are known. Engine::maps requires only sizes and photometry.
inline bool has_geometry(const Scanner& scanner) {
  return !(scanner.translation.isZero(0) && scanner.camera.intrinsic.isIdentity(0));
}

/// A scanner before calibration: frame and pattern sizes, and the photometry in `known`.
Scanner without_geometry(Size camera, Size projector, const PhotometricCalibration& known = {});

/// Throws Error unless both lenses are valid and have a size, the rotation matrix is valid (to
/// 1e-4), the baseline is finite and not zero, and photometry and depths are in range.
void require_valid(const Scanner& scanner);

/// Throws Error for ambient light, noise or gamma out of range.
void require_valid(const PhotometricCalibration& photometry);

/// sigma_w^2 at a grey level, given its value `at_half` at half of full scale. At least a twentieth
/// of `at_half`.
double noise_variance_at(double grey_level, double at_half, double gain);

/// Fills in missing sizes from the frames and the patterns, which may be empty. Throws Error,
/// beginning with `file`, if sizes differ, the projector's size is unknown, or the scanner is
/// invalid.
Scanner completed(Scanner scanner, const std::string& file, Size camera, Size projector);

/// The scanner of two perspective matrices in one world frame, mm, each up to scale: lenses without
/// distortion, skew allowed. Throws Error if the first three columns of a matrix are singular.
Scanner scanner_of(const Eigen::Matrix<double, 3, 4>& camera, Size camera_size,
                   const Eigen::Matrix<double, 3, 4>& projector, Size projector_size);

/// Throws Error if patterns along `axis` give no depth: the baseline is parallel to the stripes, so
/// that a ray meets the same stripe at every depth and Eq. (1.15) is singular.
void require_depth_visible(const Scanner& scanner, Axis axis);

/// A point of the camera's frame, in the projector's frame.
inline Eigen::Vector3d in_projector_frame(const Scanner& scanner, const Eigen::Vector3d& point) {
  return scanner.rotation * point + scanner.translation;
}

/// Centre of the projector in the camera's frame, mm. Its norm is the baseline.
inline Eigen::Vector3d projector_centre(const Scanner& scanner) {
  return -scanner.rotation.transpose() * scanner.translation;
}

/// Projector coordinate y = pixel / length, along `axis`, of a projector pixel.
inline double coordinate_along(Axis axis, const Eigen::Vector2d& pixel, Size projector) {
  return (axis == Axis::x ? pixel.x() : pixel.y()) / length_along(axis, projector);
}

}  // namespace slipstream
