// The surest neighbours first, which makes a minimum spanning tree: Judge, Quan and
// Bryanston-Cross, Optical Engineering 31 (1992); sure by second differences: Herraez et al.,
// Applied Optics 41 (2002).
#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

#include "slipstream/spatial/detail/edge_steps.h"
#include "slipstream/spatial/detail/phase_groups.h"
#include "slipstream/spatial/detail/roughness.h"

namespace slipstream {

Orders orders_by_quality(const WrappedCycles& wrapped) {
  const EdgeSteps steps = edge_steps(wrapped.cycles);
  const Image<float> rough = roughness(wrapped);
  // A float that is not negative has the order of its bits.
  std::vector<std::uint64_t> edges;
  edges.reserve(2 * rough.pixel_count());
  const int width = rough.width();
  const auto add = [&](const Image<std::int16_t>& of, int apart, std::uint32_t way) {
    for (std::size_t i = 0; i < of.pixel_count(); ++i) {
      if (of.begin()[i] == EdgeSteps::closed) continue;
      const float both = rough.begin()[i] + rough.begin()[i + static_cast<std::size_t>(apart)];
      edges.push_back(std::uint64_t{std::bit_cast<std::uint32_t>(both)} << 32U | 2 * i | way);
    }
  };
  add(steps.right, 1, 0);
  add(steps.down, width, 1);
  std::sort(edges.begin(), edges.end());
  PhaseGroups groups(rough.pixel_count());
  for (const std::uint64_t edge : edges) {
    const auto at = static_cast<int>((edge & 0xffffffffU) >> 1U);
    if ((edge & 1U) == 0)
      groups.join(at, at + 1, steps.right.begin()[at]);
    else
      groups.join(at, at + width, steps.down.begin()[at]);
  }
  return groups.orders(wrapped);
}

}  // namespace slipstream
