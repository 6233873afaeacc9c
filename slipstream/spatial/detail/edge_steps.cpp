#include "slipstream/spatial/detail/edge_steps.h"

#include <cmath>
#include <vector>

#include "slipstream/base/parallel_rows.h"

namespace slipstream {

EdgeSteps edge_steps(const Image<float>& cycles) {
  const auto [width, height] = cycles.size();
  EdgeSteps steps{Image<std::int16_t>(cycles.size(), EdgeSteps::closed),
                  Image<std::int16_t>(cycles.size(), EdgeSteps::closed)};
  for_each_row(height, [&, width = width, height = height](int row) {
    const float* const here = cycles.row(row);
    const float* const below = cycles.row(row + 1 < height ? row + 1 : row);
    for (int i = 0; i < width; ++i) {
      if (std::isnan(here[i])) continue;
      if (i + 1 < width && !std::isnan(here[i + 1])) {
        steps.right(i, row) = static_cast<std::int16_t>(step_between(here[i], here[i + 1]));
      }
      if (row + 1 < height && !std::isnan(below[i])) {
        steps.down(i, row) = static_cast<std::int16_t>(step_between(here[i], below[i]));
      }
    }
  });
  return steps;
}

Image<int> charges_of(const EdgeSteps& steps) {
  const auto [width, height] = steps.size();
  Image<int> charges({width + 1, height + 1});
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int right = steps.right(x, y), down = steps.down(x, y);
      if (right != EdgeSteps::closed) {
        charges(x + 1, y + 1) += right;
        charges(x + 1, y) -= right;
      }
      if (down != EdgeSteps::closed) {
        charges(x, y + 1) += down;
        charges(x + 1, y + 1) -= down;
      }
    }
  }
  return charges;
}

Orders flood(const WrappedCycles& wrapped, const EdgeSteps& steps) {
  Orders orders{Image<int>(steps.size()), Image<int>(steps.size(), -1)};
  int* const order = orders.order.begin();
  int* const region = orders.region.begin();
  std::vector<int> front, next;
  const auto pixels = static_cast<int>(orders.order.pixel_count());
  for (int seed = 0; seed < pixels; ++seed) {
    if (region[seed] >= 0 || !wrapped.has(static_cast<std::size_t>(seed))) continue;
    region[seed] = seed;
    for (front = {seed}; !front.empty(); front.swap(next), next.clear()) {
      for (const int at : front) {
        steps.for_each_neighbour(at, [&](int to, int step) {
          if (region[to] >= 0) return;
          region[to] = seed;
          order[to] = order[at] + step;
          next.push_back(to);
        });
      }
    }
  }
  return orders;
}

}  // namespace slipstream
