#include "slipstream/response/measurement.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/robust.h"

namespace slipstream {
namespace {

/// The lowest point of a function with one valley between two places.
template <class Function>
double lowest_between(const Function& f, double low, double high) {
  while (high - low > 1e-9) {
    const double third = (high - low) / 3;
    if (f(low + third) < f(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  return std::midpoint(low, high);
}

}  // namespace

double gamma_from_harmonics(double B_1, double B_2) {
  return (B_1 + 2 * B_2) / (B_1 - B_2);
}

Image<double> gamma_map(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit) {
  Image<double> map(pixels.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    const MeasuredHarmonics& pixel = pixels.begin()[i];
    if (lit.begin()[i] != 0) map.begin()[i] = gamma_from_harmonics(pixel.B_1(), pixel.B_2());
  }
  return map;
}

GammaEstimate robust_gamma(const Image<double>& map) {
  std::vector<double> gammas;
  std::copy_if(map.begin(), map.end(), std::back_inserter(gammas),
               [](double gamma) { return std::isfinite(gamma); });
  constexpr std::size_t fewest = 100;
  if (gammas.size() < fewest) {
    throw Error(fmt::format("{} pixels are lit and not saturated; gamma takes at least {}",
                            gammas.size(), fewest));
  }
  double centre = median(gammas);
  std::vector<double> distances;
  distances.reserve(gammas.size());
  for (const double gamma : gammas) distances.push_back(std::abs(gamma - centre));
  const double scale = std::max(deviation_from_median(median(distances)), 1e-12);
  GammaEstimate estimate{.pixels = gammas.size()};
  for (int i = 0; i < 20; ++i) {
    double weights = 0, sum = 0, squares = 0, squared_weights = 0;
    for (const double gamma : gammas) {
      const double weight = tukey_weight((gamma - centre) / scale);
      weights += weight;
      sum += weight * gamma;
      squares += weight * (gamma - centre) * (gamma - centre);
      squared_weights += weight * weight;
    }
    centre = sum / weights;
    estimate.spread = std::sqrt(squares / weights);
    estimate.standard_error = estimate.spread * std::sqrt(squared_weights) / weights;
  }
  estimate.gamma = centre;
  return estimate;
}

Histogram histogram(const Image<double>& map, double low, double high, int bins) {
  Histogram result{low, high, std::vector<std::size_t>(static_cast<std::size_t>(bins))};
  for (const double value : map) {
    const double place = (value - low) / (high - low) * bins;
    if (place >= 0 && place < bins) ++result.counts[static_cast<std::size_t>(place)];
  }
  return result;
}

LevelFit fit_levels(const Response& response, std::span<const double> values,
                    std::span<const double> intensities) {
  const auto count = static_cast<double>(values.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double light = light_at(response, values[i]);
    x += light;
    y += intensities[i];
    xx += light * light;
    xy += light * intensities[i];
  }
  LevelFit fit;
  fit.scale = (count * xy - x * y) / (count * xx - x * x);
  fit.offset = (y - fit.scale * x) / count;
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    fit.left.push_back(intensities[i] - fit.scale * light_at(response, values[i]) - fit.offset);
    sum += fit.left.back() * fit.left.back();
  }
  fit.rms = std::sqrt(sum / count);
  return fit;
}

GammaFit fit_gamma(std::span<const double> values, std::span<const double> intensities) {
  if (values.size() < 4 || values.size() != intensities.size()) {
    throw Error(
        fmt::format("{} uniform patterns with {} intensities; a fit of gamma takes at least 4",
                    values.size(), intensities.size()));
  }
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  if (*least == *most) {
    throw Error(fmt::format("uniform patterns: all have the value {}; several are needed", *least));
  }
  const auto fit_at = [&](double gamma) {
    return fit_levels(PowerLaw{gamma}, values, intensities);
  };
  const double gamma = lowest_between([&](double trial) { return fit_at(trial).rms; },
                                      least_gamma / 2, 2 * largest_gamma);
  const GammaFit fit{fit_at(gamma), gamma};
  if (!(fit.scale > 0)) {
    throw Error("uniform patterns: the intensity does not rise with the pattern's value");
  }
  return fit;
}

}  // namespace slipstream
