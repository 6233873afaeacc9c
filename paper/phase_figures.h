#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Figures 1.27 and 1.28: noise of the phase, and temporal unwrapping.
std::vector<Reproducible> phase_reproducibles();

}  // namespace slipstream
