#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "slipstream/image/image.h"

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
};

inline constexpr std::size_t validity_count = 7;

/// "valid", "too dark", ... as printed.
std::string_view name_of(Validity validity);

/// An organised point cloud: one point per camera pixel, in the camera's frame, Z forward.
struct Cloud {
  explicit Cloud(Size size = {});

  Image<double> x;  ///< mm; NaN where not valid, as y and z
  Image<double> y;
  Image<double> z;
  Image<float> intensity;  ///< texture: the mean A^c, grey levels of an 8-bit camera
  Image<Validity> validity;

  [[nodiscard]] Size size() const { return z.size(); }
};

/// Pixels of each kind of Validity, in its order.
std::array<std::size_t, validity_count> count_by_validity(const Cloud& cloud);

/// Points of the cloud.
std::size_t point_count(const Cloud& cloud);

}  // namespace slipstream
