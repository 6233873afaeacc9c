#include "slipstream/response/noise_measurement.h"

#include <cmath>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

/// Variance over the measured pixels of what `value` gives at each, times `factor`.
template <class Value>
NoiseEstimate scaled_variance(const Image<std::uint8_t>& measured, double factor,
                              const Value& value) {
  constexpr std::size_t fewest = 100;
  double mean = 0, squares = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < measured.pixel_count(); ++i) {
    if (measured.begin()[i] == 0) continue;
    ++count;
    const double x = value(i);
    const double from_mean = x - mean;
    mean += from_mean / static_cast<double>(count);
    squares += from_mean * (x - mean);
  }
  if (count < fewest) {
    throw Error(fmt::format("{} pixels are too few to measure noise; at least {} are wanted", count,
                            fewest));
  }
  const double variance = factor * squares / static_cast<double>(count - 1);
  return {.variance = variance,
          .standard_error = variance * std::sqrt(2.0 / static_cast<double>(count - 1)),
          .pixels = count};
}

}  // namespace

NoiseEstimate noise_from_means(const Image<double>& mean_1, int steps_1,
                               const Image<double>& mean_2, int steps_2,
                               const Image<std::uint8_t>& measured) {
  const double N_1 = steps_1, N_2 = steps_2;
  return scaled_variance(measured, N_1 * N_2 / (N_1 + N_2),
                         [&](std::size_t i) { return mean_1.begin()[i] - mean_2.begin()[i]; });
}

NoiseLine noise_line_from_means(const Image<double>& mean_1, const Image<double>& mean_2, int steps,
                                const Image<std::uint8_t>& measured) {
  const NoiseEstimate all = noise_from_means(mean_1, steps, mean_2, steps, measured);
  double shift = 0;  // light that changed between the scans
  for (std::size_t i = 0; i < measured.pixel_count(); ++i) {
    if (measured.begin()[i] != 0) shift += mean_1.begin()[i] - mean_2.begin()[i];
  }
  shift /= static_cast<double>(all.pixels);
  NoiseLine line{.at_half = all.variance};
  // Squares of Gaussian values spread as their mean squared: weights follow from the line itself.
  for (int iteration = 0; iteration < 5; ++iteration) {
    double w = 0, wx = 0, wxx = 0, wy = 0, wxy = 0;
    for (std::size_t i = 0; i < measured.pixel_count(); ++i) {
      if (measured.begin()[i] == 0) continue;
      const double a = mean_1.begin()[i], b = mean_2.begin()[i];
      const double x = (a + b) / 2 - 127.5, y = steps / 2.0 * (a - b - shift) * (a - b - shift);
      const double predicted = std::max(line.at_half + line.gain * x, all.variance / 20);
      const double weight = 1 / (2 * predicted * predicted);
      w += weight;
      wx += weight * x;
      wxx += weight * x * x;
      wy += weight * y;
      wxy += weight * x * y;
    }
    const double determinant = w * wxx - wx * wx;
    if (!(determinant > 1e-9 * w * wxx)) return {.at_half = all.variance};
    line = {.at_half = (wxx * wy - wx * wxy) / determinant,
            .gain = (w * wxy - wx * wy) / determinant,
            .gain_error = std::sqrt(w / determinant)};
  }
  return line;
}

NoiseEstimate noise_from_half_phase(const Image<double>& b_cos,
                                    const Image<std::uint8_t>& measured) {
  return scaled_variance(measured, 4, [&](std::size_t i) { return b_cos.begin()[i]; });
}

NoiseEstimate noise_from_half_phases(const Image<double>& b_cos_1, const Image<double>& b_cos_2,
                                     const Image<std::uint8_t>& measured) {
  return scaled_variance(measured, 2,
                         [&](std::size_t i) { return b_cos_1.begin()[i] - b_cos_2.begin()[i]; });
}

NoiseEstimate noise_from_modulations(const Image<double>& modulation_1,
                                     const Image<double>& modulation_2, int steps, double c1,
                                     const Image<std::uint8_t>& measured) {
  const double c2 = 1 - c1;
  // alpha_12 = 2 / alpha_p (B_1 / c_1 - B_2 / c_2); alpha_p cancels.
  const double factor = steps / 8.0 * (c1 * c1 * c2 * c2) / (c1 * c1 + c2 * c2) * 4;
  return scaled_variance(measured, factor, [&](std::size_t i) {
    return modulation_1.begin()[i] / c1 - modulation_2.begin()[i] / c2;
  });
}

}  // namespace slipstream
