#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/statistics.h"
#include "response/harmonics.h"
#include "response/response_fit.h"
#include "response/scan_average.h"
#include "slipstream/frame_set.h"
#include "slipstream/gamma.h"
#include "slipstream/image.h"
#include "slipstream/response.h"

namespace slipstream {

/// Gamma without calibration, Liu 2010, Section 4.3, from the frames of one sinusoid: the gamma for
/// which the second constraint holds at all pixels together; the first is (4.53). The constraint is
/// the ratio of mean and modulation for N = 3 (4.58); for N >= 4 the second harmonic relative to
/// the fundamental, as a complex number: for N = 4 it is B_cos (4.60), for N >= 5 its angle is
/// phi_2 (4.61) and its magnitude adds information. One gamma for all pixels, because for N = 3 a
/// single pixel often has several solutions. Ignores pixels that are too dark or saturated.
BlindGamma find_gamma(const FrameViews& frames, int first, int steps);

/// The same from given harmonics.
BlindGamma find_gamma(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit,
                      int steps);

/// gamma from neighbouring harmonics, Liu 2010, Eq. (4.55). B_1 != B_2.
double gamma_from_harmonics(double B_1, double B_2);

/// gamma of every pixel by Eqs. (4.50), (4.55); NaN where `lit` is 0. For N >= 5 steps; the fewer
/// the steps, the more of the harmonics N - 2 and above is aliased onto the second (Fig. 4.7).
Image<double> gamma_map(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit);

/// One gamma for a device.
struct GammaEstimate {
  double gamma = 1;
  double standard_error = 0;  ///< of gamma, if the pixels' errors are independent
  double spread = 0;          ///< standard deviation among pixels, without outliers
  std::size_t pixels = 0;     ///< number of pixels used
};

/// The pixels' common gamma: mean with Tukey's weights, starting from the median, so that edges and
/// shadows have no effect. Throws Error if the map has fewer than 100 finite pixels.
GammaEstimate robust_gamma(const Image<double>& map);

/// Gamma estimated at each pixel on its own.
struct PixelGamma {
  Image<double> map{};  ///< NaN where a pixel is unusable
  GammaEstimate estimate{};
  Histogram histogram{};  ///< five spreads on either side of the estimate
};

/// Gamma of a projector and a camera, from scans of any surface.
struct GammaCalibration {
  int steps = 0;      ///< of the band used
  BlindGamma fit{};   ///< power law fitted to all pixels with all harmonics
  double misfit = 0;  ///< of the power law: approximate phase error it leaves, rad
  /// The power law if its residual is noise; otherwise the result of curve_that_serves; otherwise,
  /// with 12 or more steps, the curve measured by the pixels if it removes 95 % of the error;
  /// nullopt if none fits. With fewer than 8 steps only a power law, as curves would overfit.
  std::optional<NamedResponse> response{};
  std::optional<PixelGamma> pixels{};  ///< from B_1 and B_2, with 5 or more steps
};

/// Uses the longest run of steps of the scans' patterns. `minimum_modulation`: grey levels of 255;
/// 0 means 16. Throws Error if the patterns have no such run or too few pixels are lit.
GammaCalibration calibrate_gamma(const ScanAverage& scans, double minimum_modulation = 0);

/// The response and the gamma nearest to it. Throws Error, with the remedy, if the scans do not
/// determine it. A linear response is valid.
MeasuredResponse found_response(const GammaCalibration& calibration);

}  // namespace slipstream
