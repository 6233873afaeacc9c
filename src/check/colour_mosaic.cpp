#include "check/colour_mosaic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/statistics.h"

namespace slipstream {

std::optional<Finding> colour_mosaic(const ScanSamples& samples) {
  // A sensor without a filter has the same gain everywhere, within 2 %.
  constexpr double least_ratio = 1.05, sure = 5;  // standard errors

  // Logarithms of the product of two diagonal pixels over the product of the others: gains of rows
  // and columns cancel.
  std::array<std::vector<double>, 2> ratios;
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    std::array<double, ScanSamples::far_right> range{};
    for (std::size_t i = 0; i < range.size(); ++i) {
      range[i] = samples.range(samples.levels(g, static_cast<ScanSamples::Place>(i)));
    }
    if (std::ranges::min(range) <= 0) continue;

    // Green pixels lie on every other diagonal, like the fields of a chequerboard.
    ratios[(samples.column(g) + samples.row(g)) % 2].push_back(
        std::log(range[0] * range[3] / (range[1] * range[2])));
  }

  if (std::min(ratios[0].size(), ratios[1].size()) < 32) return std::nullopt;

  // A gain enters each logarithm twice, upwards on one diagonal and downwards on the other: four
  // times in the difference.
  const double difference = std::abs(median(ratios[0]) - median(ratios[1]));
  const double ratio = std::exp(difference / 4);

  // Variance of the difference; 1.25 is sqrt(pi / 2), for medians of Gaussian values.
  double variance = 0;
  for (const std::vector<double>& of : ratios) {
    const double error = 1.25 * robust_deviation(of, median(of));
    variance += error * error / static_cast<double>(of.size());
  }

  if (ratio < least_ratio || difference < sure * std::sqrt(variance)) return std::nullopt;

  return Finding{
      .kind = FindingKind::colour_mosaic,
      .what = "every other pixel is brighter than its neighbours",
      .evidence = {{.name = "ratio", .value = ratio, .limit = least_ratio}},
      .causes = {{CauseKind::colour_mosaic,
                  "raw pictures of a colour camera, whose Bayer filter was not removed"}},
      .remedies = {{"name the colours of its first two pixels with `mosaic`, e.g. `mosaic RG`; if "
                    "they are not known, convert the raw pictures to grey before saving"}}};
}

}  // namespace slipstream
