#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Figures 3.16 to 3.24: a board and an angel under PMP and PCMP.
std::vector<Reproducible> pcmp_figure_reproducibles();

}  // namespace slipstream
