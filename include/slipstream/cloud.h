#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slipstream/image.h"

namespace slipstream {

/// Whether a camera pixel has a point, and if not, why.
enum class Validity : std::uint8_t {
  valid,
  too_dark,        ///< modulation below the threshold: shadow, dark surface, no projector light
  saturated,       ///< a frame is at the largest grey level, which biases the phase
  doubtful_order,  ///< low and high frequency disagree on the fringe order
  no_point,        ///< ray and stripe do not meet in front of camera and projector
  outside_field,   ///< the point is outside the projector's field: its coordinate is wrong
  out_of_range,    ///< depth outside the requested range
  // The following are removed from a finished cloud, see CleanSettings.
  low_trust,        ///< standard deviation of depth, predicted from the noise, above the limit
  mixed,            ///< off the end of a surface: the pixel sees two surfaces
  outlier,          ///< off the surface of its neighbours
  small_component,  ///< connected to too few others
  outside_region,   ///< outside the requested box or outline
  moved,            ///< changed during capture, other than by uniform motion of one surface
  reflected,        ///< lit by other surfaces too, see CleanSettings::reflection
};

inline constexpr std::size_t validity_count = 14;

/// Number of pixels for each Validity, in its order.
using ValidityCounts = std::array<std::size_t, validity_count>;

/// "valid", "too dark", ... as printed.
std::string_view name_of(Validity validity);

/// Name of the camera's frame: x right, y down, z forward, like an optical frame of ROS.
inline constexpr std::string_view camera_frame = "camera";

/// A rigid motion between two named frames: maps a point p of the frame `from` to `transform * p`
/// of the frame `to`, mm. It is also the pose of `from` in `to`.
struct FramePose {
  std::string from{}, to{};  ///< see require_frame_name
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
};

/// Throws Error unless the text can name a frame: 1 to 48 letters, digits and _ . / -, which all
/// file formats and ROS take.
void require_frame_name(std::string_view name);

FramePose inverse(const FramePose& pose);
/// First `first`, then `second`. Throws Error unless `first` ends in the frame in which `second`
/// begins.
FramePose compose(const FramePose& first, const FramePose& second);
/// The pose, or its inverse, that maps from this frame. Throws Error if neither does.
FramePose pose_from_frame(const FramePose& pose, std::string_view from);

/// An organised point cloud: one point for each camera pixel, in the camera's frame, Z forward,
/// unless it was moved. Reusing it as an output avoids allocation.
template <class Real>
struct BasicCloud {
  explicit BasicCloud(Size size = {})
      : x(size, nan),
        y(size, nan),
        z(size, nan),
        intensity(size),
        validity(size, Validity::no_point) {}

  Image<Real> x, y, z;     ///< mm; NaN where not valid
  Image<float> intensity;  ///< texture: the mean A^c, grey levels of an 8-bit camera
  Image<Validity> validity;
  Image<Colour> colour{};  ///< sRGB, of a colour camera; empty if unknown
  /// Pose from the camera's frame to the points' frame; null: the camera's.
  std::shared_ptr<const FramePose> frame{};

  [[nodiscard]] Size size() const { return z.size(); }
  /// Marks the pixel as invalid for that reason.
  void reject(int column, int row, Validity reason) {
    x(column, row) = y(column, row) = z(column, row) = nan;
    validity(column, row) = reason;
  }

 private:
  static constexpr Real nan = std::numeric_limits<Real>::quiet_NaN();
};

/// Precision of clouds that are displayed, filtered and written.
using Cloud = BasicCloud<float>;

/// Converts between precisions; reuses memory of the same size.
template <class From, class To>
void convert(const BasicCloud<From>& from, BasicCloud<To>& to) {
  convert(from.x, to.x);
  convert(from.y, to.y);
  convert(from.z, to.z);
  to.intensity = from.intensity;
  to.validity = from.validity;
  to.colour = from.colour;
  to.frame = from.frame;
}

/// Depth only, which is faster to compute and write than a Cloud.
struct Depth {
  Image<float> z;  ///< mm; NaN where not valid
  Image<Validity> validity;
};

/// Only the valid points, row by row.
struct PackedPoints {
  std::size_t count = 0;
  /// Allocated at the picture's size, to reuse memory; the first `count` values are valid.
  Image<float> x, y, z;    ///< mm
  Image<float> intensity;  ///< texture: the mean A^c, grey levels of an 8-bit camera
};

/// An intensity as an 8-bit pixel: rounded and clipped.
inline std::uint8_t grey_level(float intensity) {
  return static_cast<std::uint8_t>(std::clamp(double{intensity}, 0.0, 255.0) + 0.5);
}

/// The point's colour, or its intensity as grey, sRGB.
template <class Real>
Colour colour_at(const BasicCloud<Real>& cloud, int column, int row) {
  if (!cloud.colour.empty()) return cloud.colour(column, row);
  const std::uint8_t grey = grey_level(cloud.intensity(column, row));
  return {grey, grey, grey};
}

ValidityCounts count_by_validity(const Image<Validity>& validity);

template <class Real>
ValidityCounts count_by_validity(const BasicCloud<Real>& cloud) {
  return count_by_validity(cloud.validity);
}

/// Number of valid points.
template <class Real>
std::size_t point_count(const BasicCloud<Real>& cloud) {
  return count_by_validity(cloud)[static_cast<std::size_t>(Validity::valid)];
}

/// One standard deviation of each point due to the frames' noise, and at edges also to the mixture
/// in a pixel; NaN without a point.
struct Uncertainty {
  explicit Uncertainty(Size size = {})
      : coordinate(size, nan), x(size, nan), y(size, nan), z(size, nan), z_of_noise(size, nan) {}

  Image<float> coordinate;  ///< of the projector coordinate, fields
  Image<float> x, y, z;     ///< mm
  Image<float> z_of_noise;  ///< of depth, mm, by noise alone
  /// The deviation of depth, mm, by errors that repeat from scan to scan, such as of the
  /// calibration, which the other members leave out; may be empty. See ErrorBudget.
  Image<float> z_systematic{};

 private:
  static constexpr float nan = std::numeric_limits<float>::quiet_NaN();
};

/// The median of the standard deviations of depth, mm; 0 without points.
double median_depth(const Uncertainty& uncertainty);

/// RMS of the depth error that an uncertainty predicts, mm; 0 without points.
struct PredictedRms {
  double of_noise = 0;    ///< by noise alone
  double with_edges = 0;  ///< also by mixtures in pixels at edges

  /// Whether edges cause more of the squared error than noise.
  [[nodiscard]] bool is_of_edges() const { return with_edges > std::sqrt(2.0) * of_noise; }
};

PredictedRms predicted_rms(const Uncertainty& uncertainty);

/// Name of the frame that a cloud is in.
template <class Real>
std::string_view frame_name(const BasicCloud<Real>& cloud) {
  return cloud.frame ? std::string_view(cloud.frame->to) : camera_frame;
}

/// The frame of points that `pose` or its inverse moves out of `frame`, both as BasicCloud::frame.
/// Throws Error if the pose neither begins nor ends in it.
std::shared_ptr<const FramePose> frame_after(const std::shared_ptr<const FramePose>& frame,
                                             const FramePose& pose);

/// Moves a cloud by `pose` or its inverse, whichever begins in the cloud's frame, and its standard
/// deviations to the new axes; depth, meshes, normals, cleaning and shapes are of clouds in the
/// camera's frame, so do this last. Throws Error if the pose neither begins nor ends in the cloud's
/// frame.
void move_to_frame(Cloud& cloud, const FramePose& pose, Uncertainty* uncertainty = nullptr);

/// Throws Error if the cloud was moved out of the camera's frame, for functions that need it there.
void require_camera_frame(const Cloud& cloud);

/// Moves it back to the camera's frame; does nothing if it is there.
void move_to_camera(Cloud& cloud, Uncertainty* uncertainty = nullptr);

/// 16-bit encoding of depth: offset + scale * number; 0 means no point.
struct DepthScale {
  float scale = 0.05F;  ///< mm, above 0; the default reaches 3.3 m
  float offset = 0;     ///< mm

  /// The nearest number for a depth; 0 if NaN or out of range.
  [[nodiscard]] std::uint16_t operator()(float z) const {
    const float number = (z - offset) * (1 / scale) + 0.5F;
    return static_cast<std::uint16_t>(
        static_cast<std::int32_t>(number >= 1 && number < 65536 ? number : 0));
  }
};

/// X, Y, Z of a pixel, mm; NaN without a point.
inline Eigen::Vector3d position_at(const Cloud& cloud, int column, int row) {
  return {cloud.x(column, row), cloud.y(column, row), cloud.z(column, row)};
}

/// Distance between the rays of two points, mm, at the depth of the first; NaN if one is missing.
/// Off the axis, a jump in depth also moves a point sideways, so that the points are farther apart.
inline double distance_between_rays(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
  return first.z() * (second.head<2>() / second.z() - first.head<2>() / first.z()).norm();
}

/// Whether two points of neighbouring pixels lie on one surface: their depths differ by at most
/// `largest_step` times the distance between their rays. False if one is missing.
inline bool on_one_surface(const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                           double largest_step) {
  return std::abs(second.z() - first.z()) <= largest_step * distance_between_rays(first, second);
}

/// Signed error, mm, of z relative to the nearest `depth` of a pixel and its eight neighbours,
/// which a lens mixes; infinite without any.
inline double nearest_error(double z, const Image<double>& depth, int column, int row) {
  double nearest = std::numeric_limits<double>::infinity();
  for (int y = std::max(row - 1, 0); y <= std::min(row + 1, depth.height() - 1); ++y) {
    for (int x = std::max(column - 1, 0); x <= std::min(column + 1, depth.width() - 1); ++x) {
      const double error = z - depth(x, y);
      if (std::abs(error) < std::abs(nearest)) nearest = error;
    }
  }
  return nearest;
}

/// Every `step`-th pixel of every `step`-th row, starting with the first; step at least 1.
template <class Pixel>
Image<Pixel> subsampled(const Image<Pixel>& image, int step) {
  Image<Pixel> sparse({(image.width() + step - 1) / step, (image.height() + step - 1) / step});
  for_each_pixel_in_order(sparse.size(), [&](int column, int row) {
    sparse(column, row) = image(step * column, step * row);
  });
  return sparse;
}

/// The same for a cloud.
inline Cloud subsampled(const Cloud& cloud, int step) {
  Cloud sparse;
  for (const auto part : {&Cloud::x, &Cloud::y, &Cloud::z, &Cloud::intensity}) {
    sparse.*part = subsampled(cloud.*part, step);
  }

  sparse.validity = subsampled(cloud.validity, step);
  sparse.colour = subsampled(cloud.colour, step);
  sparse.frame = cloud.frame;
  return sparse;
}

/// Standard deviation of depth at a point P in the camera's frame, with a modulation of B grey
/// levels of the frames: sigma_Z = noise / B (projector_depth (P, 1))^2 Z / |parallax P|.
struct DepthNoise {
  float noise = 0;  ///< sigma of the projector coordinate times B
  std::array<float, 4> projector_depth{};
  std::array<float, 3> parallax{};
};

}  // namespace slipstream
