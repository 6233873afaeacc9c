#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

#include "slipstream/base/colour.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/response.h"
#include "slipstream/geometry/lens.h"

namespace slipstream {

/// What calibration knows of light and sensor; grey levels of an 8-bit camera.
struct PhotometricCalibration {
  std::optional<double> ambient{};  ///< beta of Liu 2010, Eq. (3.2), -255 to 255
  /// sigma_w^2 at half of full scale, rounding included, above 0.
  std::optional<double> noise_variance{};
  double noise_gain = 0;  ///< by which it grows with each grey level: shot noise; 0 or more
  /// How the light of projector and camera together answers a pattern's value; phases are corrected
  /// for it.
  std::optional<MeasuredResponse> response{};
  /// Of devices in colour: pictures are taken apart by it as they are read.
  std::optional<ColourMixture> colour_mixture{};

  friend bool operator==(const PhotometricCalibration&, const PhotometricCalibration&) = default;
};

/// Depths, mm, nearest first.
struct DepthRange {
  double nearest = 0;
  double farthest = 0;

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

/// Whether anybody has measured lenses and pose. Where they are as at first, sizes and photometry
/// alone are known, which suffices for all that pictures say: Engine::maps.
bool has_geometry(const Scanner& scanner);

/// What is known before a calibration: the size of the camera's frames, and what else `known` says.
Scanner without_geometry(Size camera, Size projector, const PhotometricCalibration& known = {});

/// Throws Error unless both lenses are valid with a size, the rotation is one (to 1e-4), the
/// baseline is finite and not zero, photometry and depths are in range.
void require_valid(const Scanner& scanner);

/// Throws Error for ambient light or noise out of range, or a gamma that is.
void require_valid(const PhotometricCalibration& photometry);

/// sigma_w^2 at a grey level, where it is `at_half` at half of full scale. Never less than a
/// twentieth of that.
double noise_variance_at(double grey_level, double at_half, double gain);

/// The scanner with the sizes that it does not say taken from the frames and the patterns; `camera`
/// and `projector` may be empty. Throws Error, naming `file`, where they do not agree with what it
/// says, no size is known for the projector, or the scanner is not valid.
Scanner completed(Scanner scanner, const std::string& file, Size camera, Size projector);

/// The scanner of a camera and a projector given by their perspective matrices in one world frame,
/// mm, up to scale: lenses without distortion, perhaps with skew. Throws Error where a matrix is
/// not of a camera: its first three columns are singular.
Scanner scanner_of(const Eigen::Matrix<double, 3, 4>& camera, Size camera_size,
                   const Eigen::Matrix<double, 3, 4>& projector, Size projector_size);

/// Throws Error when patterns along `axis` carry no depth for this scanner: the baseline runs along
/// the stripes, so that every ray meets the same stripe at every depth and Eq. (1.15) is singular.
void require_depth_visible(const Scanner& scanner, Axis axis);

/// A point of the camera's frame in the projector's.
Eigen::Vector3d in_projector_frame(const Scanner& scanner, const Eigen::Vector3d& point);

/// Centre of the projector in the camera's frame, mm. Its length is the baseline.
Eigen::Vector3d projector_centre(const Scanner& scanner);

/// Projector coordinate y = pixel / length, along `axis`, of a projector pixel.
double coordinate_along(Axis axis, const Eigen::Vector2d& pixel, Size projector);

}  // namespace slipstream
