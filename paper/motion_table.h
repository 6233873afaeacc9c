#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Depth errors of a moving sphere and a moving statue, by speed, frames and weights.
std::vector<Reproducible> motion_reproducibles();

}  // namespace slipstream
