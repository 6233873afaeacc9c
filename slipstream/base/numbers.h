#pragma once

#include <limits>
#include <numbers>

namespace slipstream {

inline constexpr double two_pi = 2 * std::numbers::pi;    ///< a whole turn, in radians
inline constexpr double degree = std::numbers::pi / 180;  ///< radians
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace slipstream
