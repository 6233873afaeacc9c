#include "check/unrelated_pixels.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace slipstream {
namespace {

/// Correlation between the frames of lit pixels and of their neighbours at that place.
double correlation_with(const ScanSamples& samples, ScanSamples::Place place) {
  double product = 0, square_here = 0, square_there = 0;

  for (std::size_t g = 0; g < samples.groups(); ++g) {
    if (!samples.lit(g, place)) continue;

    const float* const here = samples.levels(g, ScanSamples::middle);
    const float* const there = samples.levels(g, place);
    double mean_here = 0, mean_there = 0;
    for (int n = 0; n < samples.frames(); ++n) {
      mean_here += double{here[n]} / samples.frames();
      mean_there += double{there[n]} / samples.frames();
    }

    for (int n = 0; n < samples.frames(); ++n) {
      product += (here[n] - mean_here) * (there[n] - mean_there);
    }
    square_here += samples.variation(here);
    square_there += samples.variation(there);
  }

  // Lit pixels without lit neighbours prove no noise.
  const double squares = square_here * square_there;
  return squares > 0 ? product / std::sqrt(squares) : 1;
}

}  // namespace

std::optional<Finding> unrelated_pixels(const ScanSamples& samples) {
  // Correct scans: over 0.5 with some neighbour, also of one-bit patterns in focus. Noise: 0.01.
  constexpr double least = 0.15;

  double most = 0;
  for (const auto place : {ScanSamples::right, ScanSamples::below, ScanSamples::right_below}) {
    most = std::max(most, std::abs(correlation_with(samples, place)));
  }
  if (most >= least) return std::nullopt;

  return Finding{
      .kind = FindingKind::excess_noise,
      .severity = Severity::wrong,
      .what = "neighbouring pixels do not change together: the frames contain no pattern",
      .evidence = {{.name = "correlation of neighbours", .value = most, .limit = least}},
      .causes = {{CauseKind::noise, "noise, or pictures saved with another width or pixel type"}},
      .remedies = {{"inspect the frames with `view()`; capture the scan again"}}};
}

}  // namespace slipstream
