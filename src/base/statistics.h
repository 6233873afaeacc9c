#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <utility>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// Sum of squares, and their number.
struct Squares {
  double sum = 0;
  int count = 0;

  void add(double square) {
    sum += square;
    ++count;
  }

  void add(const Squares& other) {
    sum += other.sum;
    count += other.count;
  }

  /// 0 if empty.
  [[nodiscard]] double rms() const { return count > 0 ? std::sqrt(sum / count) : 0; }
};

/// The quantile `share` of the values, 0 (least) to 1 (greatest), without interpolation; of two
/// equally near values the greater. Reorders the values, which must be non-empty and free of NaN.
template <class Number>
Number quantile(std::vector<Number>& values, double share) {
  const auto place = values.begin() + std::lround(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// The finite values among every `step`-th pixel of an image.
template <class Number>
std::vector<Number> finite_values(const Image<Number>& image, std::size_t step = 1) {
  std::vector<Number> finite;
  for (std::size_t i = 0; i < image.pixel_count(); i += step) {
    if (std::isfinite(image.begin()[i])) finite.push_back(image.begin()[i]);
  }
  return finite;
}

/// The median of a non-empty list.
inline double median(std::vector<double> values) {
  return quantile(values, 0.5);
}

/// The median over the items, at least one: of a member, or of a function of each.
template <class Items, class Value>
double median_of(const Items& items, const Value& value) {
  std::vector<double> values;
  values.reserve(std::size(items));
  for (const auto& item : items) values.push_back(std::invoke(value, item));
  return median(std::move(values));
}

/// Tukey's biweight of a residual in standard deviations: 1 at 0, 0 from 4.685 on, which gives 95 %
/// of the efficiency of least squares on Gaussian noise.
inline double tukey_weight(double residual) {
  const double share = residual / 4.685;
  const double rest = 1 - share * share;
  return rest > 0 ? rest * rest : 0;
}

/// Standard deviation of Gaussian values whose magnitudes have that median.
inline double deviation_from_median(double median_magnitude) {
  return 1.4826 * median_magnitude;
}

/// Robust standard deviation of values about a centre, from their median absolute deviation.
inline double robust_deviation(std::vector<double> values, double centre) {
  for (double& value : values) value = std::abs(value - centre);
  return deviation_from_median(median(std::move(values)));
}

/// Counts of finite values in `bins` bins of equal width from low to high; values outside are
/// ignored.
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

/// Point (x, y) number i of a low-discrepancy sequence in [0, 1): any first part of it covers the
/// square evenly, without a grid that could alias with stripes.
inline std::pair<double, double> spread_place(int i) {
  // The inverses of 1.3247..., the root of x^3 = x + 1, and of its square.
  constexpr double step_x = 0.7548776662466927, step_y = 0.5698402909980532;
  return {std::fmod(0.5 + i * step_x, 1.0), std::fmod(0.5 + i * step_y, 1.0)};
}

}  // namespace slipstream
