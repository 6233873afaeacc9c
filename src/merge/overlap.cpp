#include "merge/overlap.h"

#include <algorithm>

namespace slipstream {

std::vector<Overlap> spread_overlaps(const std::vector<Overlap>& overlaps, std::size_t views) {
  constexpr std::size_t most_partners = 16;

  // 1. The pairs of each view, those that overlap most first.
  std::vector<std::vector<std::size_t>> of_view(views);
  for (std::size_t i = 0; i < overlaps.size(); ++i) {
    of_view[overlaps[i].first].push_back(i);
    of_view[overlaps[i].second].push_back(i);
  }

  // 2. Each view takes the first and the last of them, and others at even steps.
  std::vector<bool> is_chosen(overlaps.size());
  for (std::vector<std::size_t>& pairs : of_view) {
    std::stable_sort(pairs.begin(), pairs.end(), [&](std::size_t a, std::size_t b) {
      return overlaps[a].share > overlaps[b].share;
    });

    const std::size_t count = std::min(most_partners, pairs.size());
    for (std::size_t k = 0; k < count; ++k) {
      const std::size_t steps = std::max<std::size_t>(count - 1, 1);
      is_chosen[pairs[k * (pairs.size() - 1) / steps]] = true;
    }
  }

  // 3. In their order before.
  std::vector<Overlap> kept;
  for (std::size_t i = 0; i < overlaps.size(); ++i) {
    if (is_chosen[i]) kept.push_back(overlaps[i]);
  }
  return kept;
}

}  // namespace slipstream
