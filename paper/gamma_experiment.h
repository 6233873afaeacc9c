#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Sections 4.4 and 4.5: two cameras, and the experiments, on the virtual scanner; Figures 4.11 to
/// 4.26 from them.
std::vector<Reproducible> gamma_experiment_reproducibles();

}  // namespace slipstream
