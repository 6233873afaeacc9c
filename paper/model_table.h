#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Error of a model of an object that turns once.
std::vector<Reproducible> model_reproducibles();

}  // namespace slipstream
