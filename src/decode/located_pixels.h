#pragma once

#include <cmath>

#include "slipstream/image.h"

namespace slipstream {

/// Positions of pixels in the projector's field.
struct LocatedPixels {
  explicit LocatedPixels(Size size) : coordinate(size, std::nanf("")), modulation(size) {}

  Image<float> coordinate;  ///< along the axis; NaN if unknown
  Image<float> modulation;  ///< grey levels of the frames; 0 if unknown
};

}  // namespace slipstream
