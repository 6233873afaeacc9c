#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include "slipstream/base/converted.h"
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
/// Kept and handed in again it is written anew without allocation.
template <class Real>
struct BasicCloud {
  explicit BasicCloud(Size size = {})
      : x(size, nan),
        y(size, nan),
        z(size, nan),
        intensity(size),
        validity(size, Validity::no_point) {}

  Image<Real> x;  ///< mm; NaN where not valid, as y and z
  Image<Real> y;
  Image<Real> z;
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

/// The points alone, without the pixels that have none, in the order of the picture: row by row.
struct PackedPoints {
  std::size_t count = 0;
  /// Of the picture's size, so that memory is used again: the first `count` are the points', what
  /// is behind them says nothing.
  Image<float> x;  ///< mm, as y and z
  Image<float> y;
  Image<float> z;
  Image<float> intensity;  ///< texture: the mean A^c, grey levels of an 8-bit camera
};

/// An intensity as a pixel of 8 bits: rounded, what is darker or brighter taken to the nearest end.
std::uint8_t grey_level(float intensity);

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

}  // namespace slipstream
