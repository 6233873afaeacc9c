#include "slipstream/spatial/detail/methods.h"

#include <array>
#include <cmath>
#include <limits>

#include "slipstream/base/parallel_rows.h"
#include "slipstream/base/statistics.h"

namespace slipstream {
namespace {

/// Of the difference of two phases in [-0.5, 0.5].
float nearest(float difference) {
  return difference - (difference > 0.5F ? 1.F : 0.F) + (difference < -0.5F ? 1.F : 0.F);
}

}  // namespace

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

Image<float> roughness(const WrappedCycles& wrapped) {
  const Image<float>& cycles = wrapped.cycles;
  const auto [width, height] = cycles.size();
  Image<float> result(cycles.size());
  for_each_row(height, [&, width = width, height = height](int row) {
    // Nothing around, so that no pixel is a special one.
    const std::vector<float> empty(static_cast<std::size_t>(width) + 2,
                                   std::numeric_limits<float>::quiet_NaN());
    std::array<std::vector<float>, 3> lines{empty, empty, empty};
    for (int i = std::max(row - 1, 0); i < std::min(row + 2, height); ++i) {
      std::copy_n(cycles.row(i), width, lines[static_cast<std::size_t>(i - row + 1)].begin() + 1);
    }
    const float *const above = lines[0].data(), *const here = lines[1].data(),
                       *const below = lines[2].data();
    float* const to = result.row(row);
    for (int i = 0; i < width; ++i) {
      float sum = 0, found = 0;
      const auto add = [&, middle = here[i + 1]](float before, float after) {
        const float second = nearest(before - middle) - nearest(middle - after);
        const bool is_there = second == second;
        sum += is_there ? second * second : 0;
        found += is_there ? 1.F : 0.F;
      };
      add(here[i], here[i + 2]);
      add(above[i + 1], below[i + 1]);
      add(above[i], below[i + 2]);
      add(above[i + 2], below[i]);
      to[i] = found > 0 ? sum / found : 1;
    }
    if (wrapped.quality.empty()) return;
    const float* const quality = wrapped.quality.row(row);
    for (int i = 0; i < width; ++i) to[i] /= quality[i] * quality[i];
  });
  return result;
}

Image<float> smoothness(const WrappedCycles& wrapped) {
  Image<float> result = roughness(wrapped);
  std::vector<float> some;
  for (std::size_t i = 0; i < result.pixel_count(); ++i) {
    if (wrapped.has(i)) some.push_back(result.begin()[i]);
  }
  if (some.empty()) return result;
  const float usual = 4 * quantile(some, 0.5) + 1e-9F;
  for (float& each : result) each = usual / (usual + each);
  return result;
}

}  // namespace slipstream
