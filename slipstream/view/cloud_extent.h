#pragma once

#include "slipstream/base/image.h"
#include "slipstream/view/orbit_camera.h"
#include "slipstream/view/point_images.h"

namespace slipstream::view {

/// From a low to a high value.
struct Range {
  float low = 0;
  float high = 1;
};

/// From the 1st to the 99th percentile of the finite values, of some thousands of them evenly
/// spread; [0, 1] where none is finite.
Range robust_range(const Image<float>& values);

/// Where a cloud is and how dense, so that a few outliers do not matter.
struct CloudExtent {
  Box box;            ///< robust_range in each direction
  float spacing = 1;  ///< mm from a point to the next at the middle depth, the median
};

/// Of an empty cloud: the box of a millimetre.
CloudExtent extent_of(const PointImages& cloud);

/// Y of the floor, mm: a little under the cloud, so that it does not cut what stands on it.
float floor_height(const CloudExtent& extent);

}  // namespace slipstream::view
