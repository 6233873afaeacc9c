#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/response.h"
#include "slipstream/response/pixel_harmonics.h"

namespace slipstream {

/// gamma from neighbouring harmonics, Liu 2010, Eq. (4.55). B_1 != B_2.
double gamma_from_harmonics(double B_1, double B_2);

/// gamma of every pixel by Eqs. (4.50), (4.55); NaN where `lit` is 0. For N >= 5 steps; the fewer
/// they are, the more of the harmonics N - 2 and above is taken for the second (Fig. 4.7).
Image<double> gamma_map(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit);

/// One gamma for a device.
struct GammaEstimate {
  double gamma = 1;
  double standard_error = 0;  ///< of gamma, if the pixels' errors are independent
  double spread = 0;          ///< standard deviation among pixels, outliers left out
  std::size_t pixels = 0;     ///< how many spoke
};

/// The pixels' common gamma: their mean with Tukey's weights, so that edges and shadows do not
/// count, from the median. Throws Error where the map has fewer than 100 finite pixels.
GammaEstimate robust_gamma(const Image<double>& map);

/// How many of the finite values fall into each of as many bins of one width; values outside are
/// not counted.
struct Histogram {
  double low = 0;
  double high = 1;
  std::vector<std::size_t> counts;
};
Histogram histogram(const Image<double>& map, double low, double high, int bins);

/// The intensities (grey levels) seen at uniform patterns of those values, [0, 1], fitted by
/// scale light + offset, the light being that of a response.
struct LevelFit {
  double scale = 0;            ///< grey levels
  double offset = 0;           ///< grey levels: ambient light
  double rms = 0;              ///< of what the curve leaves, grey levels
  std::vector<double> left{};  ///< that of each level, grey levels
};
LevelFit fit_levels(const Response& response, std::span<const double> values,
                    std::span<const double> intensities);

/// The traditional measurement (4.2): the same by value^gamma.
struct GammaFit : LevelFit {
  double gamma = 1;
};

/// Least squares. Throws Error for fewer than 4 values, values that are all one, or intensities
/// that do not rise.
GammaFit fit_gamma(std::span<const double> values, std::span<const double> intensities);

}  // namespace slipstream
