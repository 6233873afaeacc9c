#pragma once

#include <limits>

#include "slipstream/base/image.h"

namespace slipstream {

/// How sure the points of a cloud are: one standard deviation of what the frames' noise does to
/// each. NaN where there is no point.
struct Uncertainty {
  explicit Uncertainty(Size size = {})
      : coordinate(size, nan), x(size, nan), y(size, nan), z(size, nan) {}

  Image<float> coordinate;  ///< of the projector coordinate, fields
  Image<float> x;           ///< mm, as y and z
  Image<float> y;
  Image<float> z;

 private:
  static constexpr float nan = std::numeric_limits<float>::quiet_NaN();
};

/// The median of the standard deviations of depth, mm; 0 where there is no point.
double median_depth(const Uncertainty& uncertainty);

}  // namespace slipstream
