#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Table 4.1 and Figures 4.1 to 4.10: the gamma model without noise.
std::vector<Reproducible> gamma_model_reproducibles();

}  // namespace slipstream
