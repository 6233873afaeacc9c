#pragma once

#include <cstddef>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/depth_rows.h"

namespace slipstream {

/// Steps and bends beyond which a cloud has an edge, from samples of the cloud itself: of the
/// distance between the points of neighbouring pixels and of what the noise does to depth, both
/// over the depth. `samples`: memory that is kept. Infinite, so that nothing is an edge, where the
/// cloud has hardly a point.
DepthLimits depth_limits(const Cloud& cloud, std::vector<float>& samples);

/// What is kept from cloud to cloud.
struct SurfaceMemory {
  struct Point {
    int column = 0, row = 0;
    float x = 0, y = 0, z = 0;
  };
  std::vector<Point> found;
  Image<float> z;
};

/// Gives a point to each pixel that has none and lies, in its row or its column, in a gap of at
/// most `widest` pixels between points of one surface: straight between them, where there are both
/// the mean. Pixels outside the region or the range asked for stay empty. Returns how many got one.
std::size_t fill_gaps(Cloud& cloud, int widest, const DepthLimits& limits, SurfaceMemory& memory);

/// Moves each point along its ray to the mean of the pairs of points on either side of it, up to
/// `reach` pixels away, that bend no more than one surface does. A plane stays one.
void smooth(Cloud& cloud, int reach, const DepthLimits& limits, SurfaceMemory& memory);

}  // namespace slipstream
