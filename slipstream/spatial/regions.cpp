// Regions without a wrap, joined by the longest borders first: Gierloff, SPIE 818 (1987).
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "slipstream/spatial/detail/edge_steps.h"
#include "slipstream/spatial/detail/phase_groups.h"

namespace slipstream {
namespace {

/// Where two regions touch, and how often by each step from the first to the second.
struct Border {
  std::uint64_t regions = 0;
  std::array<int, 3> votes{};  ///< for -1, 0, 1 period

  [[nodiscard]] int step() const {
    return static_cast<int>(std::max_element(votes.begin(), votes.end()) - votes.begin()) - 1;
  }
  [[nodiscard]] int lead() const {
    return 2 * *std::max_element(votes.begin(), votes.end()) - votes[0] - votes[1] - votes[2];
  }
};

/// One for each pair of regions.
std::vector<Border> merged(std::vector<Border> single) {
  std::sort(single.begin(), single.end(),
            [](const Border& a, const Border& b) { return a.regions < b.regions; });
  std::vector<Border> borders;
  for (const Border& each : single) {
    if (borders.empty() || borders.back().regions != each.regions)
      borders.push_back({each.regions});
    for (std::size_t i = 0; i < each.votes.size(); ++i) borders.back().votes[i] += each.votes[i];
  }
  return borders;
}

}  // namespace

Orders orders_by_regions(const WrappedCycles& wrapped) {
  constexpr float largest_step = 0.25F;  // periods, within a region
  const EdgeSteps steps = edge_steps(wrapped.cycles);
  const float* const cycles = wrapped.cycles.begin();
  const auto pixels = static_cast<int>(wrapped.cycles.pixel_count());
  PhaseGroups groups(wrapped.cycles.pixel_count());
  for (int at = 0; at < pixels; ++at) {
    steps.for_each_neighbour(at, [&](int to, int) {
      if (to > at && std::abs(cycles[to] - cycles[at]) <= largest_step) groups.join(at, to, 0);
    });
  }
  std::vector<Border> borders;
  for (int at = 0; at < pixels; ++at) {
    const auto from = static_cast<std::uint32_t>(groups.find(at).group);
    steps.for_each_neighbour(at, [&](int to, int step) {
      const auto other = static_cast<std::uint32_t>(groups.find(to).group);
      if (from >= other) return;  // each is met from both sides
      borders.push_back({std::uint64_t{from} << 32U | other});
      borders.back().votes[static_cast<std::size_t>(step + 1)] = 1;
    });
  }
  borders = merged(std::move(borders));
  std::stable_sort(borders.begin(), borders.end(),
                   [](const Border& a, const Border& b) { return a.lead() > b.lead(); });
  for (const Border& border : borders) {
    groups.join(static_cast<int>(border.regions >> 32U),
                static_cast<int>(border.regions & 0xffffffffU), border.step());
  }
  return groups.orders(wrapped);
}

}  // namespace slipstream
