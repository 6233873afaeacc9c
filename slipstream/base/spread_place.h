#pragma once

#include <cmath>

namespace slipstream {

/// A place in the unit square.
struct SpreadPlace {
  double x = 0, y = 0;  ///< [0, 1)
};

/// Place i of a row of places any first part of which is spread evenly, without a grid that stripes
/// could fall in step with.
inline SpreadPlace spread_place(int i) {
  // The inverses of 1.3247..., the root of x^3 = x + 1, and of its square.
  constexpr double step_x = 0.7548776662466927, step_y = 0.5698402909980532;
  return {std::fmod(0.5 + i * step_x, 1.0), std::fmod(0.5 + i * step_y, 1.0)};
}

}  // namespace slipstream
