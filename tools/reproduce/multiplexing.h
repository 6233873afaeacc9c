#pragma once

#include <vector>

#include "tools/reproduce/reproduction.h"

namespace slipstream {

/// Tables 3.1 to 3.3 by the published rule and by the default one, and Tables 3.5 and 3.7 on the
/// virtual scanner, of Liu 2010.
std::vector<Reproducible> multiplexing_table_reproducibles();

/// Figures 3.1 to 3.3, 3.5, 3.7, 3.8, 3.10 and 3.11: noise, as predicted and as measured.
std::vector<Reproducible> noise_figure_reproducibles();

}  // namespace slipstream
