#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "slipstream/base/image.h"

namespace slipstream {

/// How far a depth is from the nearest of the surfaces, `depth`, that a pixel and its eight
/// neighbours see, since a lens mixes those: mm, with its sign; infinite where there is none.
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

}  // namespace slipstream
