#include "slipstream/simulate/nearest_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slipstream {

double nearest_error(double z, const Image<double>& depth, int column, int row) {
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
