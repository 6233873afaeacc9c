#pragma once

#include <cmath>

#include "slipstream/cloud.h"

namespace slipstream {

/// A bent, textured sheet of 24x16 pixels with a hole.
inline Cloud sheet_cloud() {
  Cloud cloud({24, 16});
  for (int row = 0; row < 16; ++row) {
    for (int column = 0; column < 24; ++column) {
      cloud.intensity(column, row) = static_cast<float>((column * 37 + row * 11) % 256);
      if (std::hypot(column - 9, row - 7) < 3) continue;
      const float u = 0.02F * static_cast<float>(column - 12);
      const float v = 0.02F * static_cast<float>(row - 8);
      const float z = 600 + 40 * u + 300 * u * v;
      cloud.x(column, row) = u * z;
      cloud.y(column, row) = v * z;
      cloud.z(column, row) = z;
      cloud.validity(column, row) = Validity::valid;
    }
  }
  return cloud;
}

}  // namespace slipstream
