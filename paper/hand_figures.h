#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Figures 2.3 and 2.4: a moving hand.
std::vector<Reproducible> hand_reproducibles();

}  // namespace slipstream
