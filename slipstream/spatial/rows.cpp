// Fringes counted along each row, the rows then tied to each other where they first touch: Nakadate
// and Saito, Applied Optics 24 (1985).
#include "slipstream/spatial/detail/edge_steps.h"
#include "slipstream/spatial/detail/phase_groups.h"

namespace slipstream {

Orders orders_by_rows(const WrappedCycles& wrapped) {
  const EdgeSteps steps = edge_steps(wrapped.cycles);
  PhaseGroups groups(wrapped.cycles.pixel_count());
  const auto join = [&](const Image<std::int16_t>& edges, int apart) {
    for (std::size_t i = 0; i < edges.pixel_count(); ++i) {
      const auto at = static_cast<int>(i);
      const std::int16_t step = edges.begin()[i];
      if (step != EdgeSteps::closed) groups.join(at, at + apart, step);
    }
  };
  join(steps.right, 1);
  join(steps.down, wrapped.cycles.width());
  return groups.orders(wrapped);
}

}  // namespace slipstream
