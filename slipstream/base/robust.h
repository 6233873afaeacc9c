#pragma once

#include <vector>

#include "slipstream/base/quantile.h"

namespace slipstream {

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

}  // namespace slipstream
