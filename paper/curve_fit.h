#pragma once

#include <cmath>
#include <vector>

#include "response/response_fit.h"

namespace slipstream {

/// The curve scale x^gamma + offset.
struct FittedGamma {
  double gamma = 1;
  double scale = 0, offset = 0;  ///< grey levels

  [[nodiscard]] double at(double x) const { return scale * std::pow(x, gamma) + offset; }
};

/// Traditional calibration of gamma: the curve with the least squared distance to the grey levels
/// measured at projected intensities x in [0, 1]. Searches gamma from 0.5 to 12.
FittedGamma fit_gamma(const std::vector<double>& x, const std::vector<double>& grey_levels);

}  // namespace slipstream
