#include "slipstream/response/ambient_measurement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/decode/reflectivity.h"

namespace slipstream {
namespace {

/// Mean of the values in the one grey level, wherever it begins, that holds most of them.
double mode_of(const std::vector<double>& sorted) {
  std::size_t first = 0, best_first = 0, best_count = 0;
  for (std::size_t last = 0; last < sorted.size(); ++last) {
    while (sorted[last] - sorted[first] > 1) ++first;
    if (last - first + 1 > best_count) {
      best_count = last - first + 1;
      best_first = first;
    }
  }
  double sum = 0;
  for (std::size_t i = best_first; i < best_first + best_count; ++i) sum += sorted[i];
  return sum / static_cast<double>(best_count);
}

}  // namespace

Image<double> ambient_map(const Image<double>& mean, const Image<double>& modulation,
                          const PatternLight& light, double least_alpha,
                          const Image<std::uint8_t>& measured) {
  Image<double> map(mean.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < map.pixel_count(); ++i) {
    const double alpha = reflectivity(modulation.begin()[i], light.alpha_p);
    if (measured.begin()[i] == 0 || !(alpha >= least_alpha)) continue;
    map.begin()[i] = ambient_light(mean.begin()[i], alpha, light);
  }
  return map;
}

AmbientEstimate ambient_estimate(const Image<double>& map) {
  constexpr std::size_t fewest = 100;
  std::vector<double> values;
  std::copy_if(map.begin(), map.end(), std::back_inserter(values),
               [](double value) { return std::isfinite(value); });
  if (values.size() < fewest) {
    throw Error(
        fmt::format("{} pixels are bright enough to measure ambient light; at least {} are "
                    "wanted",
                    values.size(), fewest));
  }
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  AmbientEstimate estimate{
      .mode = mode_of(values), .median = values[values.size() / 2], .pixels = values.size()};
  for (const double value : values) estimate.mean += value / count;
  for (const double value : values) {
    const double from_mean = value - estimate.mean;
    estimate.variance += from_mean * from_mean / (count - 1);
  }
  return estimate;
}

}  // namespace slipstream
