#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Section 3.3 on a virtual foam board: Figures 3.12 to 3.15, the noise by each equation, 3-pattern
/// PCMP, and Tables 3.4 and 3.6.
std::vector<Reproducible> foam_board_reproducibles();

}  // namespace slipstream
