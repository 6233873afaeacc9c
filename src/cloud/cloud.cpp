#include "slipstream/cloud.h"

#include <functional>
#include <vector>

#include "base/statistics.h"

namespace slipstream {
namespace {

constexpr std::array<std::string_view, validity_count> validity_names{
    "valid",
    "too dark",
    "saturated",
    "doubtful fringe order",
    "no point",
    "outside the projector's field",
    "out of range",
    "low trust",
    "mixed pixel",
    "outlier",
    "small component",
    "outside the region",
    "moved"};

}  // namespace

std::string_view name_of(Validity validity) {
  return validity_names[static_cast<std::size_t>(validity)];
}

ValidityCounts count_by_validity(const Image<Validity>& validity) {
  // Several counters: neighbours usually count the same, and each increment waits for the last.
  constexpr std::size_t at_once = 8;
  std::array<std::array<std::uint32_t, 16>, at_once> of_each{};

  const std::size_t whole = validity.pixel_count() / at_once * at_once;
  for (const Validity* pixel = validity.begin(); pixel != validity.begin() + whole;
       pixel += at_once) {
    for (std::size_t i = 0; i < at_once; ++i) ++of_each[i][static_cast<std::size_t>(pixel[i])];
  }

  // The last few pixels, and the sum of the counters.
  ValidityCounts counts{};
  std::for_each(validity.begin() + whole, validity.end(),
                [&](Validity rest) { ++counts[static_cast<std::size_t>(rest)]; });
  for (const auto& one : of_each) {
    std::transform(counts.begin(), counts.end(), one.begin(), counts.begin(), std::plus<>());
  }

  return counts;
}

PredictedRms predicted_rms(const Uncertainty& uncertainty) {
  double noise = 0, all = 0, count = 0;
  for (std::size_t i = 0; i < uncertainty.z.pixel_count(); ++i) {
    const double sigma = uncertainty.z.begin()[i], of_noise = uncertainty.z_of_noise.begin()[i];
    if (!std::isfinite(sigma)) continue;
    noise += of_noise * of_noise;
    all += sigma * sigma;
    ++count;
  }

  if (count == 0) return {};
  return {std::sqrt(noise / count), std::sqrt(all / count)};
}

double median_depth(const Uncertainty& uncertainty) {
  std::vector<float> sigma = finite_values(uncertainty.z);
  return sigma.empty() ? 0 : quantile(sigma, 0.5);
}

}  // namespace slipstream
