#pragma once

#include "slipstream/base/image.h"

namespace slipstream::view {

/// A cloud as it is drawn: images of one size, which are not copied. One of a single row is a list
/// of points; of more, a camera's picture, whose neighbours lie on one surface.
struct PointImages {
  const Image<float>& x;  ///< mm, scanner's frame; a pixel without a point is NaN, as y and z
  const Image<float>& y;
  const Image<float>& z;
  const Image<float>& intensity;          ///< grey levels of an 8-bit camera
  const Image<float>* shading = nullptr;  ///< how bright, 0 to 1; null: all as bright
};

}  // namespace slipstream::view
