#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Figures 3.1 to 3.3, 3.5, 3.7, 3.8, 3.10 and 3.11: noise, predicted and measured.
std::vector<Reproducible> noise_figure_reproducibles();

}  // namespace slipstream
