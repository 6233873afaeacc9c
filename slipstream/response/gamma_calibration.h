#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "slipstream/base/image.h"
#include "slipstream/base/statistics.h"
#include "slipstream/codes/response.h"
#include "slipstream/response/gamma_choice.h"
#include "slipstream/response/harmonics.h"
#include "slipstream/response/response_fit.h"
#include "slipstream/response/scan_average.h"

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

/// What each pixel says of gamma by itself.
struct PixelGamma {
  Image<double> map{};  ///< NaN where a pixel does not speak
  GammaEstimate estimate{};
  Histogram histogram{};  ///< five spreads either side of the estimate
};

/// Gamma of a projector and a camera, from scans of any surface.
struct GammaCalibration {
  int steps = 0;      ///< of the band that it was found with
  BlindGamma fit{};   ///< to all pixels with all harmonics, a power law
  double misfit = 0;  ///< of the power law, about the phase error it leaves, rad
  /// The power law where it leaves no more than noise, else what curve_that_serves, else the curve
  /// that the pixels see of 12 steps and more, if it takes 95 % of the error away; none where
  /// nothing does, and for other curves with less than 8 steps: they fit curves that are not there.
  std::optional<NamedResponse> response{};
  std::optional<PixelGamma> pixels{};  ///< from B_1 and B_2, where there are 5 steps and more
};

/// By the longest run of steps of the scans' patterns. `minimum_modulation`: grey levels of 255; 16
/// where 0. Throws Error where the patterns have no such run or too few pixels are lit.
GammaCalibration calibrate_gamma(const ScanAverage& scans, double minimum_modulation = 0);

/// The response and the gamma nearest to it. Throws Error, saying what to do, where the scans do
/// not tell. That there is no distortion to see is no reason.
MeasuredResponse found_response(const GammaCalibration& calibration);

}  // namespace slipstream
