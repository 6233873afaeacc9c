// Pixels where second differences say that a way would not be safe are left out of the flood, and
// follow a neighbour afterwards: Bone, Applied Optics 30 (1991).
#include <algorithm>
#include <vector>

#include "slipstream/spatial/detail/edge_steps.h"
#include "slipstream/spatial/detail/roughness.h"

namespace slipstream {

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

}  // namespace slipstream
