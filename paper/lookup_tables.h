#pragma once

#include <vector>

#include "paper/reproduction.h"

namespace slipstream {

/// Figure 2.1, Tables 2.1 and 2.2: look-up tables. Times are of this machine.
std::vector<Reproducible> lookup_table_reproducibles();

}  // namespace slipstream
