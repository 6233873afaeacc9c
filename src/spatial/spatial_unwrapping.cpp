#include "slipstream/spatial_unwrapping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "spatial/methods.h"

namespace slipstream {
namespace {

/// Wraps the difference of two phases in [-0.5, 0.5].
float nearest(float difference) {
  return difference - (difference > 0.5F ? 1.F : 0.F) + (difference < -0.5F ? 1.F : 0.F);
}

struct Method : SpatialUnwrapping {
  Orders (*orders)(const WrappedCycles&);
};

constexpr std::array methods{
    Method{{"rows", "counts fringes along rows"}, orders_by_rows},
    Method{{"flood", "flood fill around rough pixels"}, orders_by_flood},
    Method{{"branch-cuts", "flood fill between branch cuts"}, orders_by_branch_cuts},
    Method{{"regions", "joins wrap-free regions along their borders"}, orders_by_regions},
    Method{{"quality", "most reliable neighbours first"}, orders_by_quality},
    Method{{"least-squares", "weighted least-squares surface"}, orders_by_least_squares},
    Method{{"flow", "minimum-cost flow between residues"}, orders_by_flow},
};

const Method& method_named(std::string_view name) {
  const auto* const found = std::ranges::find(methods, name, &Method::name);
  if (found != methods.end()) return *found;

  std::vector<std::string_view> names;
  for (const Method& method : methods) names.push_back(method.name);

  throw Error(fmt::format("unwrapping '{}' is not known{}; expected one of {}", name,
                          did_you_mean(name, names), fmt::join(names, ", ")));
}

void require_size(Size size, Size other, const char* what) {
  throw_if(size != other, "{} is {}, but the phase {}; both must have one size", what,
           text_of(other), text_of(size));
}

template <class Number>
WrappedCycles cycles_of(const Image<Number>& wrapped, const Image<float>& quality) {
  // Beyond it, neighbouring floats are more than 0.06 rad apart.
  constexpr double largest = 1e6;
  WrappedCycles cycles{Image<float>(wrapped.size(), std::numeric_limits<float>::quiet_NaN()),
                       quality};

  for (std::size_t i = 0; i < wrapped.pixel_count(); ++i) {
    const auto phase = static_cast<double>(wrapped.begin()[i]);
    if (!std::isfinite(phase)) continue;

    throw_if(std::abs(phase) > largest, "phase {:g} rad is out of range; limit {:g}", phase,
             largest);

    cycles.cycles.begin()[i] = static_cast<float>(phase / two_pi - std::rint(phase / two_pi));
  }

  // Pixels of unknown quality come last.
  constexpr float unknown = 1e-9F;
  for (float& each : cycles.quality) each = std::isfinite(each) ? std::max(each, unknown) : unknown;

  return cycles;
}

/// Numbers the regions by size.
std::vector<PhaseRegion> number_by_size(Image<int>& region) {
  std::vector<std::size_t> sizes(region.pixel_count()), labels;

  for (const int label : region) {
    if (label >= 0 && sizes[label]++ == 0) labels.push_back(label);
  }

  // Largest first; equal ones in the order of their labels.
  std::sort(labels.begin(), labels.end(), [&](std::size_t a, std::size_t b) {
    return std::pair(sizes[b], a) < std::pair(sizes[a], b);
  });

  std::vector<PhaseRegion> regions;
  std::vector<int> numbers(region.pixel_count());
  for (const std::size_t label : labels) {
    regions.push_back({sizes[label]});
    numbers[label] = static_cast<int>(regions.size());
  }

  for (int& label : region) label = label < 0 ? 0 : numbers[label];
  return regions;
}

template <class Number>
void move(UnwrappedPhase<Number>& unwrapped, const std::vector<double>& periods) {
  for (std::size_t i = 0; i < unwrapped.phase.pixel_count(); ++i) {
    const int label = unwrapped.region.begin()[i];
    if (label == 0) continue;

    Number& phase = unwrapped.phase.begin()[i];
    phase = static_cast<Number>(phase + two_pi * periods[label - 1]);
  }
}

}  // namespace

EdgeSteps edge_steps(const Image<float>& cycles) {
  EdgeSteps steps{Image<std::int16_t>(cycles.size(), EdgeSteps::closed),
                  Image<std::int16_t>(cycles.size(), EdgeSteps::closed)};

  for_each_pixel(cycles.size(), [&](int column, int row) {
    const float here = cycles(column, row);

    const auto set = [&](Image<std::int16_t>& edges, int to_column, int to_row) {
      if (to_column == cycles.width() || to_row == cycles.height()) return;

      const float there = cycles(to_column, to_row);
      if (std::isnan(here) || std::isnan(there)) return;

      edges(column, row) = static_cast<std::int16_t>(step_between(here, there));
    };

    set(steps.right, column + 1, row);
    set(steps.down, column, row + 1);
  });

  return steps;
}

Image<int> charges_of(const EdgeSteps& steps) {
  const auto [width, height] = steps.size();
  Image<int> charges({width + 1, height + 1});

  // A step belongs to the loops around both corners of its edge, in opposite directions.
  const auto open = [](int step) { return step == EdgeSteps::closed ? 0 : step; };
  for_each_pixel_in_order(steps.size(), [&](int x, int y) {
    const int right = open(steps.right(x, y)), down = open(steps.down(x, y));
    charges(x + 1, y + 1) += right - down;
    charges(x + 1, y) -= right;
    charges(x, y + 1) += down;
  });

  return charges;
}

Orders flood(const WrappedCycles& wrapped, const EdgeSteps& steps) {
  Orders orders{Image<int>(steps.size()), Image<int>(steps.size(), -1)};
  int* const order = orders.order.begin();
  int* const region = orders.region.begin();
  std::vector<int> front, next;
  const auto pixels = static_cast<int>(orders.order.pixel_count());

  for (int seed = 0; seed < pixels; ++seed) {
    if (region[seed] >= 0 || !wrapped.has(seed)) continue;
    region[seed] = seed;

    // Breadth first: the last front and its unvisited neighbours.
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
    // NaN around the picture, so that border pixels need no special case.
    const std::vector<float> empty(width + 2, std::numeric_limits<float>::quiet_NaN());
    std::array<std::vector<float>, 3> lines{empty, empty, empty};
    for (int i = std::max(row - 1, 0); i < std::min(row + 2, height); ++i) {
      std::copy_n(cycles.row(i), width, lines[i - row + 1].begin() + 1);
    }

    const float *const above = lines[0].data(), *const here = lines[1].data(),
                       *const below = lines[2].data();
    float* const to = result.row(row);

    // The mean squared second difference along row, column and both diagonals.
    for (int i = 0; i < width; ++i) {
      float sum = 0, found = 0;

      const auto add = [&, middle = here[i + 1]](float before, float after) {
        const float second = nearest(before - middle) - nearest(middle - after);

        // False for NaN, where a neighbour is missing.
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

  // A weight of a half at four times the median roughness; 1e-9 avoids 0 / 0.
  const float usual = 4 * quantile(some, 0.5) + 1e-9F;
  for (float& each : result) each = usual / (usual + each);
  return result;
}

std::vector<SpatialUnwrapping> spatial_unwrappings() {
  return {methods.begin(), methods.end()};
}

template <class Number>
UnwrappedPhase<Number> unwrap_in_space(const Image<Number>& wrapped, const Image<float>& quality,
                                       std::string_view method) {
  const Method& chosen = method_named(method);
  if (!quality.empty()) require_size(wrapped.size(), quality.size(), "the quality");

  Orders orders = chosen.orders(cycles_of(wrapped, quality));
  UnwrappedPhase<Number> result{
      Image<Number>(wrapped.size(), std::numeric_limits<Number>::quiet_NaN()),
      std::move(orders.region),
      {}};
  result.regions = number_by_size(result.region);

  // The order of the first pixel of each region becomes 0.
  constexpr double unknown = std::numeric_limits<double>::infinity();
  std::vector<double> first(result.regions.size(), unknown);
  for (std::size_t i = 0; i < wrapped.pixel_count(); ++i) {
    const int label = result.region.begin()[i];
    if (label == 0) continue;

    const auto phase = static_cast<double>(wrapped.begin()[i]);
    const double order = orders.order.begin()[i] - std::rint(phase / two_pi);

    double& start = first[label - 1];
    if (start == unknown) start = order;
    result.phase.begin()[i] = static_cast<Number>(phase + two_pi * (order - start));
  }

  return result;
}

template <class Number>
void anchor_at(UnwrappedPhase<Number>& unwrapped, int column, int row, double phase) {
  const auto [width, height] = unwrapped.phase.size();
  const bool inside = column >= 0 && row >= 0 && column < width && row < height;

  const int label = inside ? unwrapped.region(column, row) : 0;
  throw_if(label == 0, "anchor pixel (row {}, column {}) has no valid phase", row, column);
  if (!std::isfinite(phase)) throw Error("the phase of an anchor is not finite");

  std::vector<double> periods(unwrapped.regions.size());
  periods[label - 1] = std::rint((phase - unwrapped.phase(column, row)) / two_pi);
  unwrapped.regions[label - 1].anchored = true;
  move(unwrapped, periods);
}

template <class Number>
void anchor_by(UnwrappedPhase<Number>& unwrapped, const Image<Number>& coarse) {
  require_size(unwrapped.phase.size(), coarse.size(), "the coarse phase");

  // Periods from each pixel to the coarse phase, by region.
  std::vector<std::vector<double>> differences(unwrapped.regions.size());
  for (std::size_t i = 0; i < coarse.pixel_count(); ++i) {
    const int label = unwrapped.region.begin()[i];
    const double difference = (coarse.begin()[i] - unwrapped.phase.begin()[i]) / two_pi;

    if (label == 0 || !std::isfinite(difference)) continue;
    differences[label - 1].push_back(difference);
  }

  std::vector<double> periods(unwrapped.regions.size());
  for (std::size_t n = 0; n < periods.size(); ++n) {
    if (differences[n].empty()) continue;
    periods[n] = std::rint(quantile(differences[n], 0.5));
    unwrapped.regions[n].anchored = true;
  }

  move(unwrapped, periods);
}

template UnwrappedPhase<float> unwrap_in_space(const Image<float>&, const Image<float>&,
                                               std::string_view);
template UnwrappedPhase<double> unwrap_in_space(const Image<double>&, const Image<float>&,
                                                std::string_view);
template void anchor_at(UnwrappedPhase<float>&, int, int, double);
template void anchor_at(UnwrappedPhase<double>&, int, int, double);
template void anchor_by(UnwrappedPhase<float>&, const Image<float>&);
template void anchor_by(UnwrappedPhase<double>&, const Image<double>&);

}  // namespace slipstream
