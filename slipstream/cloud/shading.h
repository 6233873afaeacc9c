#pragma once

#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// How bright each point of an organised cloud looks under a light over the viewer's left shoulder:
/// 0.3 for what is turned away, 1 for what faces it, in between where the slope is not known. From
/// smoothed_normals, so that the form shows and the noise of depth does
/// not.
Image<float> shading(const Cloud& cloud);

}  // namespace slipstream
