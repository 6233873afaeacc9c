#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Figures 1.43 to 1.45: harmonics of a distorted sinusoid.
std::vector<Reproducible> harmonic_reproducibles();

}  // namespace slipstream
