#include "slipstream/spatial/detail/edge_steps.h"

#include <cmath>
#include <vector>

#include "slipstream/image/parallel_rows.h"

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

int charge_at(const EdgeSteps& steps, int column, int row) {
  const auto step = [&](const Image<std::int16_t>& image, int x, int y) -> int {
    if (x < 0 || y < 0 || x >= image.width() || y >= image.height()) return 0;
    return image(x, y) == EdgeSteps::closed ? 0 : image(x, y);
  };
  return step(steps.right, column - 1, row - 1) + step(steps.down, column, row - 1) -
         step(steps.right, column - 1, row) - step(steps.down, column - 1, row - 1);
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
