#include "slipstream/decode/intensity_ratio.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace slipstream {

IntensityRatio::IntensityRatio() {
  for (int i = 0; i <= segments; ++i) {
    const double ratio = static_cast<double>(i) / segments;
    angle_[static_cast<std::size_t>(i)] = std::atan2(std::numbers::sqrt3 * ratio, 2 - ratio);
  }
}

double IntensityRatio::wrapped_phase(std::span<const double> I) const {
  constexpr double sixth = std::numbers::pi / 3;
  const auto [least, greatest] = std::minmax({I[0], I[1], I[2]});
  if (!(greatest > least)) return 0;
  const double middle = I[0] + I[1] + I[2] - least - greatest;
  const double place = (middle - least) / (greatest - least) * segments;
  const auto left = static_cast<std::size_t>(std::clamp(place, 0.0, segments - 1.0));
  const double within =
      std::lerp(angle_[left], angle_[left + 1], place - static_cast<double>(left));
  // From the greatest at n = 0 the ratio rises while n = 1 comes up to it, then falls.
  const bool first = I[0] == greatest, second = !first && I[1] == greatest;
  if (first) return I[1] >= I[2] ? within : within == 0 ? 0 : 6 * sixth - within;
  if (second) return I[0] >= I[2] ? 2 * sixth - within : 2 * sixth + within;
  return I[1] >= I[0] ? 4 * sixth - within : 4 * sixth + within;
}

}  // namespace slipstream
