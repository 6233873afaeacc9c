// Which of the pairs of many views are compared.
#include "merge/overlap.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

namespace slipstream::overlap_test {

/// Views around an object: each overlaps those up to `reach` places away, less the farther.
std::vector<Overlap> ring(std::size_t views, std::size_t reach) {
  std::vector<Overlap> overlaps;
  for (std::size_t i = 0; i < views; ++i) {
    for (std::size_t k = i + 1; k < views; ++k) {
      const std::size_t apart = std::min(k - i, views - (k - i));
      if (apart > reach) continue;
      overlaps.push_back({i, k, 1 - static_cast<double>(apart) / static_cast<double>(views)});
    }
  }
  return overlaps;
}

TEST(OverlapSpreadOverlaps, KeepsAllPairsOfFewViews) {
  EXPECT_EQ(spread_overlaps(ring(12, 4), 12).size(), 48U);
  EXPECT_TRUE(spread_overlaps({}, 3).empty());
}

TEST(OverlapSpreadOverlaps, GivesEachOfManyViewsNearAndFarPartners) {
  constexpr std::size_t views = 100, reach = 26;
  const std::vector<Overlap> kept = spread_overlaps(ring(views, reach), views);
  EXPECT_LE(kept.size(), 16 * views);

  for (std::size_t view = 0; view < views; ++view) {
    std::vector<double> shares;
    for (const Overlap& pair : kept) {
      if (pair.first == view || pair.second == view) shares.push_back(pair.share);
    }
    EXPECT_GE(shares.size(), 16U) << view;
    EXPECT_EQ(*std::ranges::max_element(shares), 0.99) << view;
    EXPECT_EQ(*std::ranges::min_element(shares), 0.74) << view;
  }
}

}  // namespace slipstream::overlap_test
