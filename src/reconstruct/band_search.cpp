#include "reconstruct/band_search.h"

#include <algorithm>

#include "base/numbers.h"
#include "slipstream/unwrapping.h"

namespace slipstream {

BandSearch band_search(const Layout& layout, int width) {
  // Search range in the second camera on either side of the place given by the projector, as a
  // share of the width; with gamma 3, three steps are off by a tenth of the field.
  constexpr double coarse_reach = 0.15;

  BandSearch search;
  double before = 0;

  for (const std::size_t i : coarse_to_fine(layout)) {
    const double periods = layout.bands[i].periods;

    // Seen from the coarser band, a period of this one is a fraction of a turn.
    search.fringes.push_back(static_cast<float>(before == 0 ? two_pi : two_pi * before / periods));

    // The coarsest of several bands is searched widely, in steps of two hundredths of its period.
    if (before == 0 && layout.bands.size() > 1) {
      constexpr double little = 0.02;  // periods
      search.reach = static_cast<int>(coarse_reach * width);
      search.stride = std::clamp(static_cast<int>(little * width / periods), 1, 12);
    }

    before = periods;
  }

  search.quarter = static_cast<float>(0.25 / before);
  return search;
}

}  // namespace slipstream
