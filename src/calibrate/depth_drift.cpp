#include "calibrate/depth_drift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/statistics.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

/// Each value's median with its neighbours, so that a single one off does not count.
std::vector<double> without_single_outliers(std::span<const double> values) {
  std::vector<double> smooth(values.begin(), values.end());
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    smooth[i] = median({values[i - 1], values[i], values[i + 1]});
  }

  // The ends have one neighbour.
  smooth.front() = smooth[1];
  smooth.back() = smooth[smooth.size() - 2];
  return smooth;
}

/// The standard deviation of noise from second differences, which a steady drift does not change.
double noise_of(std::span<const double> values) {
  std::vector<double> differences;
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    differences.push_back(std::abs(values[i - 1] - 2 * values[i] + values[i + 1]));
  }

  // A second difference has the variance of 1 + 4 + 1 values.
  return deviation_from_median(median(std::move(differences))) / std::sqrt(6);
}

/// The mean between the quartiles of a non-empty list: as robust as the median to a quarter of
/// outliers on either side, but not stuck at 0 if a few of the values, of 8-bit frames, repeat.
double mean_between_quartiles(std::vector<double> values) {
  std::ranges::sort(values);
  const auto quarter = static_cast<std::ptrdiff_t>(values.size() / 4);
  const auto begin = values.begin() + quarter, end = values.end() - quarter;
  return std::accumulate(begin, end, 0.0) / static_cast<double>(end - begin);
}

}  // namespace

DepthChange depth_change(const Image<float>& before, const Image<float>& now) {
  constexpr int parts = 4;  // along each side of the picture
  constexpr std::size_t least = 100;
  const Size size = before.size();
  throw_if(now.size() != size, "depths of {} and {} pixels cannot be compared", text_of(size),
           text_of(now.size()));

  // 1. The changes of all pixels with a point, part by part.
  std::vector<double> all;
  std::array<std::vector<double>, parts * parts> in_part;
  for_each_pixel_in_order(size, [&](int column, int row) {
    const double change = static_cast<double>(now(column, row)) - before(column, row);
    if (!std::isfinite(change)) return;
    all.push_back(change);

    const int part = row * parts / size.height * parts + column * parts / size.width;
    in_part[static_cast<std::size_t>(part)].push_back(change);
  });

  throw_if(all.size() < least,
           "only {} pixels have a point in both scans; expected at least {} to compare them",
           all.size(), least);

  // 2. The mean of all, and the spread of the means of parts that have enough pixels.
  DepthChange change{.mean = mean_between_quartiles(std::move(all))};
  Squares uneven;
  for (std::vector<double>& changes : in_part) {
    if (changes.size() < least) continue;
    const double about = mean_between_quartiles(std::move(changes)) - change.mean;
    uneven.add(about * about);
  }

  change.uneven = uneven.rms();
  return change;
}

Steadiness steadiness(std::span<const double> times, std::span<const double> values) {
  constexpr double share = 0.05;      // of the whole change
  constexpr double deviations = 3.0;  // of the noise
  throw_if(values.size() < least_values_to_judge || times.size() != values.size(),
           "{} values at {} times do not tell drift from noise; expected at least {}",
           values.size(), times.size(), least_values_to_judge);

  // 1. The final level, and the band about it.
  const std::vector<double> smooth = without_single_outliers(values);
  const auto last_third = smooth.begin() + static_cast<std::ptrdiff_t>(2 * smooth.size() / 3);
  const auto [least, most] = std::ranges::minmax(smooth);

  Steadiness found{.noise = noise_of(values), .level = median({last_third, smooth.end()})};
  found.band = std::max(deviations * found.noise, share * (most - least));

  // 2. The values after the last one outside.
  const auto is_outside = [&](double value) { return std::abs(value - found.level) > found.band; };
  const auto outside = std::find_if(smooth.rbegin(), smooth.rend(), is_outside);
  const auto begin = outside.base();
  if (begin <= last_third) found.since = times[static_cast<std::size_t>(begin - smooth.begin())];
  return found;
}

}  // namespace slipstream
