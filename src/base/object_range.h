#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace slipstream {

/// From the 1st to the 99th percentile of depths; of an object alone if there is a background
/// behind a gap of more than a third of that range. The object has a tenth of the depths or more,
/// and is not flat. Sorts the depths, which must be non-empty and free of NaN.
template <class Number>
std::pair<Number, Number> range_of_object(std::vector<Number>& depths) {
  std::sort(depths.begin(), depths.end());
  const auto at = [&](double share) {
    return depths[static_cast<std::size_t>(share * static_cast<double>(depths.size() - 1))];
  };

  // Points between object and background, as mixed pixels, are fewer than one step.
  constexpr double first = 0.1, step = 0.02;
  const Number low = at(0.01), high = at(0.99);
  for (double share = first; share + step < 0.99; share += step) {
    const Number end = at(share);
    const bool is_flat = 20 * (end - low) <= high - low;
    if (3 * (at(share + step) - end) > high - low && !is_flat) return {low, end};
  }

  return {low, high};
}

}  // namespace slipstream
