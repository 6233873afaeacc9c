#pragma once

#include <algorithm>

#include "slipstream/spatial/detail/edge_steps.h"

namespace slipstream {

/// What `flow` pays to change the step between two pixels by `change`, 1 or -1, the first time:
/// by how much the square of the difference grows, so that what is nearly half a period gives way
/// first, and less where the smoothness is.
inline int cost_of_change(const WrappedCycles& wrapped, const Image<float>& smoothness, int from,
                          int to, int change) {
  const float first = wrapped.cycles.begin()[from], second = wrapped.cycles.begin()[to];
  const float rest = second - first + static_cast<float>(step_between(first, second));
  const float weight = 100 * std::min(smoothness.begin()[from], smoothness.begin()[to]);
  return 1 + static_cast<int>(weight * (1 + 2 * static_cast<float>(change) * rest));
}

}  // namespace slipstream
