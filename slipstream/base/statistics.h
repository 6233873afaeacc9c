#pragma once

#include <cmath>
#include <vector>

#include "slipstream/base/image.h"

namespace slipstream {

/// The value that has a share of the others below it, 0 for the least to 1 for the greatest; of two
/// that are as near the greater. The values, at least one and none of them NaN, are put in another
/// order.
template <class Number>
Number quantile(std::vector<Number>& values, double share) {
  const auto place = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// The values of a picture that are finite, of every `step`-th pixel.
template <class Number>
std::vector<Number> finite_values(const Image<Number>& image, std::size_t step = 1) {
  std::vector<Number> finite;
  for (std::size_t i = 0; i < image.pixel_count(); i += step) {
    if (std::isfinite(image.begin()[i])) finite.push_back(image.begin()[i]);
  }
  return finite;
}

/// The middle value of a list that is not empty.
inline double median(std::vector<double> values) {
  return quantile(values, 0.5);
}

/// Tukey's weight of a residual in units of the standard deviation: 1 at 0, 0 from 4.685 on, where
/// it keeps 95 % of the efficiency of least squares on Gaussian noise.
inline double tukey_weight(double residual) {
  const double share = residual / 4.685;
  const double rest = 1 - share * share;
  return rest > 0 ? rest * rest : 0;
}

/// The standard deviation of Gaussian values with that median of their magnitudes.
inline double deviation_from_median(double median_magnitude) {
  return 1.4826 * median_magnitude;
}

/// The standard deviation of Gaussian values about their centre by the median of their distances.
inline double robust_deviation(std::vector<double> values, double centre) {
  for (double& value : values) value = std::abs(value - centre);
  return deviation_from_median(median(std::move(values)));
}

/// How many of the finite values fall into each of as many bins of one width; values outside are
/// not counted.
struct Histogram {
  double low = 0;
  double high = 1;
  std::vector<std::size_t> counts;
};
inline Histogram histogram(const Image<double>& map, double low, double high, int bins) {
  Histogram result{low, high, std::vector<std::size_t>(static_cast<std::size_t>(bins))};
  for (const double value : map) {
    const double place = (value - low) / (high - low) * bins;
    if (place >= 0 && place < bins) ++result.counts[static_cast<std::size_t>(place)];
  }
  return result;
}

/// Three times the mean over a window around each pixel, of odd width and height: near to a
/// Gaussian of half of them as standard deviations, and nothing passes of what repeats after its
/// width along rows or its height along columns. Beyond the edges there is nothing: means are over
/// what there is. In place; `scratch` takes the picture's size.
void take_moving_mean(Image<float>& picture, Size window, Image<float>& scratch);

/// The odd length next to one.
int odd_length(double length);

/// A place in the unit square.
struct SpreadPlace {
  double x = 0, y = 0;  ///< [0, 1)
};

/// Place i of a row of places any first part of which is spread evenly, without a grid that stripes
/// could fall in step with.
inline SpreadPlace spread_place(int i) {
  // The inverses of 1.3247..., the root of x^3 = x + 1, and of its square.
  constexpr double step_x = 0.7548776662466927, step_y = 0.5698402909980532;
  return {std::fmod(0.5 + i * step_x, 1.0), std::fmod(0.5 + i * step_y, 1.0)};
}

}  // namespace slipstream
