#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include <Eigen/Core>

#include "slipstream/base/image.h"

namespace slipstream {

/// Why a camera pixel has a point or none.
enum class Validity : std::uint8_t {
  valid,
  too_dark,        ///< modulation below the threshold: shadow, dark surface, no projector light
  saturated,       ///< some frame shows the largest grey level, so that the phase is biased
  doubtful_order,  ///< low and high frequency disagree on the fringe order
  no_point,        ///< ray and stripe meet nowhere in front of camera and projector
  outside_field,   ///< the point lies where the projector sends no light: its coordinate is wrong
  out_of_range,    ///< depth outside the range asked for
  // What follows is left out of a finished cloud, see CleanSettings.
  low_trust,        ///< standard deviation of depth, as the noise predicts it, above the limit
  mixed,            ///< at the end of a surface and off it: the pixel sees two
  outlier,          ///< off the surface that its neighbours agree on
  small_component,  ///< connected with too few others
  outside_region,   ///< outside the box or the outline asked for
  moved,  ///< changed while it was measured, and not as an even motion of one surface does
};

inline constexpr std::size_t validity_count = 13;

/// Pixels of each kind of Validity, in its order.
using ValidityCounts = std::array<std::size_t, validity_count>;

/// "valid", "too dark", ... as printed.
std::string_view name_of(Validity validity);

/// An organised point cloud: one point for each camera pixel, in the camera's frame, Z forward.
/// Handed in again it is written without allocation.
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

  [[nodiscard]] Size size() const { return z.size(); }
  /// The pixel has no point, for that reason.
  void leave_out(int column, int row, Validity reason) {
    x(column, row) = y(column, row) = z(column, row) = nan;
    validity(column, row) = reason;
  }

 private:
  static constexpr Real nan = std::numeric_limits<Real>::quiet_NaN();
};

/// What is shown, filtered and written.
using Cloud = BasicCloud<float>;

/// From one precision to the other; memory is used where it is of the size.
template <class From, class To>
void convert(const BasicCloud<From>& from, BasicCloud<To>& to) {
  convert(from.x, to.x);
  convert(from.y, to.y);
  convert(from.z, to.z);
  to.intensity = from.intensity;
  to.validity = from.validity;
}

/// Depth alone: less is computed and written than for a Cloud.
struct Depth {
  Image<float> z;  ///< mm; NaN where not valid
  Image<Validity> validity;
};

/// The points without the pixels that have none, row by row.
struct PackedPoints {
  std::size_t count = 0;
  /// Of the picture's size, so that memory is used again: the first `count` are the points'.
  Image<float> x, y, z;    ///< mm
  Image<float> intensity;  ///< texture: the mean A^c, grey levels of an 8-bit camera
};

/// An intensity as a pixel of 8 bits: rounded and clipped.
inline std::uint8_t grey_level(float intensity) {
  return static_cast<std::uint8_t>(std::clamp(double{intensity}, 0.0, 255.0) + 0.5);
}

ValidityCounts count_by_validity(const Image<Validity>& validity);

template <class Real>
ValidityCounts count_by_validity(const BasicCloud<Real>& cloud) {
  return count_by_validity(cloud.validity);
}

/// Points of the cloud.
template <class Real>
std::size_t point_count(const BasicCloud<Real>& cloud) {
  return count_by_validity(cloud)[static_cast<std::size_t>(Validity::valid)];
}

/// What the frames' noise does to each point, one standard deviation; NaN where there is no point.
struct Uncertainty {
  explicit Uncertainty(Size size = {})
      : coordinate(size, nan), x(size, nan), y(size, nan), z(size, nan) {}

  Image<float> coordinate;  ///< of the projector coordinate, fields
  Image<float> x, y, z;     ///< mm

 private:
  static constexpr float nan = std::numeric_limits<float>::quiet_NaN();
};

/// The median of the standard deviations of depth, mm; 0 where there is no point.
double median_depth(const Uncertainty& uncertainty);

/// How 16 bits tell a depth: `offset` and `scale` times the number. 0 tells of no point.
struct DepthScale {
  float scale = 0.05F;  ///< mm, above 0; to 3.3 m
  float offset = 0;     ///< mm

  /// The number that is nearest to a depth; 0 where it is NaN, or where 16 bits cannot tell it.
  [[nodiscard]] std::uint16_t operator()(float z) const {
    const float number = (z - offset) * (1 / scale) + 0.5F;
    return static_cast<std::uint16_t>(
        static_cast<std::int32_t>(number >= 1 && number < 65536 ? number : 0));
  }
};

/// X, Y, Z of a pixel, mm; NaN where it has no point.
inline Eigen::Vector3d position_at(const Cloud& cloud, int column, int row) {
  return {cloud.x(column, row), cloud.y(column, row), cloud.z(column, row)};
}

/// Whether two points of neighbouring pixels lie on one surface: their depths differ by at most
/// `largest_step` times the distance between their rays at the depth of the first. False where one
/// is missing.
inline bool on_one_surface(const Eigen::Vector3d& first, const Eigen::Vector3d& second,
                           double largest_step) {
  // Between the rays, and not the points: off the axis a jump in depth moves a point sideways too.
  const double across =
      first.z() * (second.head<2>() / second.z() - first.head<2>() / first.z()).norm();
  return std::abs(second.z() - first.z()) <= largest_step * across;
}

/// From the nearest of the surfaces, `depth`, that a pixel and its eight neighbours see, since a
/// lens mixes those: mm, with its sign; infinite where there is none.
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

/// Every `step`-th pixel of every `step`-th row, from the first on; step 1 or more.
template <class Pixel>
Image<Pixel> subsampled(const Image<Pixel>& image, int step) {
  Image<Pixel> sparse({(image.width() + step - 1) / step, (image.height() + step - 1) / step});
  for_each_pixel_in_order(sparse.size(), [&](int column, int row) {
    sparse(column, row) = image(step * column, step * row);
  });
  return sparse;
}

/// The same of a cloud.
inline Cloud subsampled(const Cloud& cloud, int step) {
  Cloud sparse;
  for (const auto part : {&Cloud::x, &Cloud::y, &Cloud::z, &Cloud::intensity}) {
    sparse.*part = subsampled(cloud.*part, step);
  }
  sparse.validity = subsampled(cloud.validity, step);
  return sparse;
}

}  // namespace slipstream
