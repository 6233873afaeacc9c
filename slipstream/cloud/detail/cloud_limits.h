#pragma once

#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/depth_rows.h"

namespace slipstream {

/// Steps and bends beyond which a cloud has an edge, from samples of the cloud itself: of the
/// distance between the points of neighbouring pixels and of what the noise does to depth, both
/// over the depth. `samples`: memory that is kept. Infinite, so that nothing is an edge, where the
/// cloud has hardly a point.
DepthLimits depth_limits(const Cloud& cloud, std::vector<float>& samples);

}  // namespace slipstream
