#pragma once

#include "python/bindings/keywords.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream::python {

/// By `scene` or `mesh`, `world`, `scanner` or `camera`, `ambient`, `noise_variance`,
/// `reflectivity`, `response`, `bits`, `seed`, `rays`, and how it moves from frame to frame:
/// `step`, mm, and `turn`, degrees about the upright axis.
VirtualWorld world_from(Keywords& keywords);

}  // namespace slipstream::python
