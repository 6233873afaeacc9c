// Methods that join pixels to groups, one edge after the other.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "slipstream/spatial/detail/methods.h"

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

/// Fringes counted along each row, the rows then tied to each other where they first touch:
/// Nakadate and Saito, Applied Optics 24 (1985).
Orders orders_by_rows(const WrappedCycles& wrapped) {
  const EdgeSteps steps = edge_steps(wrapped.cycles);
  PhaseGroups groups(wrapped.cycles.pixel_count());
  steps.for_each_edge([&](int at, int to, int step) { groups.join(at, to, step); });
  return groups.orders(wrapped);
}

/// Pixels where second differences say that a way would not be safe are left out of the flood, and
/// follow a neighbour afterwards: Bone, Applied Optics 30 (1991).
Orders orders_by_flood(const WrappedCycles& wrapped) {
  constexpr float roughest = 0.04F;  // periods squared
  const EdgeSteps all = edge_steps(wrapped.cycles);
  const Image<float> rough = roughness({wrapped.cycles, {}});
  const auto is_rough = [&](int at) { return rough.begin()[at] > roughest; };
  EdgeSteps open = all;
  std::vector<int> front, next;
  for (int at = 0; at < static_cast<int>(rough.pixel_count()); ++at) {
    if (!is_rough(at)) front.push_back(at);
    all.for_each_neighbour(at, [&](int to, int) {
      if (to > at && (is_rough(at) || is_rough(to))) open.edge(at, to) = EdgeSteps::closed;
    });
  }
  std::vector<bool> reached(rough.pixel_count());
  for (; !front.empty(); front.swap(next), next.clear()) {
    for (const int at : front) {
      all.for_each_neighbour(at, [&](int to, int step) {
        if (!is_rough(to) || reached[static_cast<std::size_t>(to)]) return;
        reached[static_cast<std::size_t>(to)] = true;
        open.edge(std::min(at, to), std::max(at, to)) =
            static_cast<std::int16_t>(to > at ? step : -step);
        next.push_back(to);
      });
    }
  }
  return flood(wrapped, open);
}

/// The surest neighbours first, which makes a minimum spanning tree: Judge, Quan and
/// Bryanston-Cross, Optical Engineering 31 (1992); sure by second differences: Herraez et al.,
/// Applied Optics 41 (2002).
Orders orders_by_quality(const WrappedCycles& wrapped) {
  EdgeSteps steps = edge_steps(wrapped.cycles);
  const Image<float> rough = roughness(wrapped);
  const int width = rough.width();
  // A float that is not negative has the order of its bits.
  std::vector<std::uint64_t> edges;
  edges.reserve(2 * rough.pixel_count());
  steps.for_each_edge([&](int at, int to, int) {
    const auto both = std::bit_cast<std::uint32_t>(rough.begin()[at] + rough.begin()[to]);
    const std::uint64_t place = 2 * static_cast<std::uint64_t>(at) + (to - at == width ? 1 : 0);
    edges.push_back(std::uint64_t{both} << 32U | place);
  });
  std::sort(edges.begin(), edges.end());
  PhaseGroups groups(rough.pixel_count());
  for (const std::uint64_t edge : edges) {
    const auto at = static_cast<int>((edge & 0xffffffffU) >> 1U);
    const int to = at + ((edge & 1U) == 0 ? 1 : width);
    groups.join(at, to, steps.edge(at, to));
  }
  return groups.orders(wrapped);
}

/// Regions without a wrap, joined by the longest borders first: Gierloff, SPIE 818 (1987).
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
