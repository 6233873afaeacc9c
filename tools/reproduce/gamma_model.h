#pragma once

#include <vector>

#include "tools/reproduce/reproduction.h"

namespace slipstream {

/// Table 4.1 and Figures 4.1 to 4.10 of Liu 2010: the gamma model without noise.
std::vector<Reproducible> gamma_model_reproducibles();

/// Sections 4.4 and 4.5: two cameras, and the experiments, on the virtual scanner.
std::vector<Reproducible> gamma_experiment_reproducibles();

}  // namespace slipstream
