#pragma once

#include <cstddef>
#include <cstdint>

#include "slipstream/base/image.h"
#include "slipstream/codes/pattern_set.h"

namespace slipstream {

/// How the ambient light beta of Eq. (3.5) is spread over the pixels, grey levels.
struct AmbientEstimate {
  double mode = 0;  ///< where most pixels are: centre of mass of the fullest grey level
  double median = 0;
  double mean = 0;
  double variance = 0;
  std::size_t pixels = 0;
};

/// Beta of every pixel by Eqs. (3.5), (3.6); NaN where the reflectivity is below `least_alpha`,
/// because the noise of beta falls with it (3.42), or `measured` is 0. `mean` and `modulation` are
/// those of PMP, grey levels.
Image<double> ambient_map(const Image<double>& mean, const Image<double>& modulation,
                          const PatternLight& light, double least_alpha,
                          const Image<std::uint8_t>& measured);

/// Of the finite pixels of such a map. Throws Error where there are fewer than 100.
AmbientEstimate ambient_estimate(const Image<double>& map);

}  // namespace slipstream
