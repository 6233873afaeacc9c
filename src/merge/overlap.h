#pragma once

#include <cstddef>
#include <vector>

namespace slipstream {

/// Two views that may be compared, and how much of one the other covers, 0 to 1.
struct Overlap {
  std::size_t first = 0, second = 0;  ///< indices of the views
  double share = 0;
};

/// Chooses for each of `views` views up to 16 of its pairs, from the largest overlap to the
/// smallest: near views match best, and far ones keep errors from adding up. A pair that either view
/// chooses is kept, so the time for many views grows with their number and not with its square.
/// Keeps the order.
std::vector<Overlap> spread_overlaps(const std::vector<Overlap>& overlaps, std::size_t views);

}  // namespace slipstream
