#pragma once

#include <vector>

#include "slipstream/layout.h"

namespace slipstream {

/// Search ranges of the bands, from few periods to many.
struct BandSearch {
  std::vector<float> fringes;  ///< a period of each, in rad of the band before
  int reach = 12;              ///< of the first, pixels
  int stride = 1;              ///< pixels over which the phase of the first changes little
  float quarter = 0;           ///< of a period of the last, fields
};

/// `width`: of the second camera.
BandSearch band_search(const Layout& layout, int width);

}  // namespace slipstream
