#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include "slipstream/image.h"

namespace slipstream {

/// How the depth of a fixed scene has changed, mm.
struct DepthChange {
  double mean = 0;  ///< of the pixels between the quartiles
  /// RMS of these means of 4x4 parts of the picture about the picture's.
  double uneven = 0;
};

/// Compares pixels that have a point, not NaN, in both. Throws Error if sizes differ or fewer than
/// 100 pixels have.
DepthChange depth_change(const Image<float>& before, const Image<float>& now);

/// Since when a value that drifts stays near its final level.
struct Steadiness {
  double noise = 0;  ///< standard deviation of a value about its neighbours
  double level = 0;  ///< median of the last third
  /// Largest distance from the level that counts as steady: 5 % of the whole change, or three times
  /// the noise if that is more.
  double band = 0;
  /// From here on all values lie within the band; nullopt unless all of the last third do. A single
  /// value off, such as of one bad scan, is ignored.
  std::optional<double> since{};
};

/// Fewer values do not tell drift from noise.
inline constexpr std::size_t least_values_to_judge = 9;

/// `times`: ascending, one for each value. Throws Error for fewer than least_values_to_judge.
Steadiness steadiness(std::span<const double> times, std::span<const double> values);

}  // namespace slipstream
