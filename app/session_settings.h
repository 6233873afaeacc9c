#pragma once

#include <string>
#include <vector>

#include "slipstream/sequence.h"

namespace slipstream::app {

/// Labels of this strategy, and of common ones that a projector may show instead.
std::vector<std::string> strategy_labels(const Strategy& strategy);

/// Whether motion compensation is possible: the patterns are one sinusoid, or PCMP's two in the
/// same frames, shown repeatedly.
bool takes_motion(const Sequence& sequence);

}  // namespace slipstream::app
