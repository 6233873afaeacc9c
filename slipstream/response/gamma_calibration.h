#pragma once

#include <optional>

#include "slipstream/response/blind.h"
#include "slipstream/response/measurement.h"
#include "slipstream/response/response_fit.h"
#include "slipstream/response/scan_average.h"

namespace slipstream {

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
