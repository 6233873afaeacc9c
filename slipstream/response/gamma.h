#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "slipstream/base/image.h"
#include "slipstream/base/statistics.h"
#include "slipstream/codes/response.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/response/correction.h"
#include "slipstream/response/response_fit.h"
#include "slipstream/response/scan_average.h"

namespace slipstream {

/// Why a scan does not say what its gamma is.
enum class BlindRefusal {
  none,
  too_few_pixels,  ///< that are lit and not saturated
  ambient_light,   ///< N = 3: it shows in A / B as gamma does
  no_distortion,   ///< gamma is 1 within its uncertainty
  no_power_law,    ///< what is seen fits no gamma, or one out of range
};

/// A sentence without a stop.
std::string_view reason_of(BlindRefusal refusal);

/// Gamma as one scan tells it by itself.
struct BlindGamma {
  BlindRefusal refusal = BlindRefusal::none;
  double gamma = 1;           ///< the best found, also where it is refused
  double standard_error = 0;  ///< if the pixels' errors are independent
  std::size_t pixels = 0;     ///< how many were asked

  /// The gamma to correct with: nothing where it is refused.
  [[nodiscard]] std::optional<double> accepted() const {
    return refusal == BlindRefusal::none ? std::optional(gamma) : std::nullopt;
  }
};

/// Gamma without calibration, Liu 2010, Section 4.3, from the frames of one sinusoid: the gamma
/// with which the second constraint holds at all pixels together, the first being (4.53). The
/// constraint is the ratio of mean and modulation for N = 3 (4.58); for N >= 4 the second harmonic,
/// taken relative to the fundamental as a complex number: for N = 4 it is B_cos (4.60), for N >= 5
/// its angle is phi_2 (4.61) and its length says more. One gamma for all pixels, because for N = 3
/// a pixel alone often has several solutions. Pixels too dark or saturated are not asked.
BlindGamma find_gamma(const FrameViews& frames, int first, int steps);

/// The same from harmonics already at hand.
BlindGamma find_gamma(const Image<MeasuredHarmonics>& pixels, const Image<std::uint8_t>& lit,
                      int steps);

/// The response that a scan's phases are corrected for, and why that one.
struct GammaChoice {
  std::optional<MeasuredResponse> response{};  ///< none: phases are left alone
  std::string source = "none";    ///< "scanner file", "blind", "given", "two cameras" or "none"
  std::optional<double> gamma{};  ///< nothing for a measured curve; told also where refused
  std::optional<BlindGamma> blind{};
  std::string sentence{};  ///< for people; empty where nothing was corrected or asked for
};

/// By `how`: "scanner" (what the scanner holds, if it does), "none", or a number. Throws Error for
/// anything else, for "blind" by saying that it takes a scan.
GammaChoice choose_gamma(const std::string& how, const std::optional<MeasuredResponse>& of_scanner);

/// The same of a scan, and so also by "blind": from the frames themselves, of the scan's runs of
/// steps by the one that is surest.
GammaChoice choose_gamma(const std::string& how, const std::optional<MeasuredResponse>& of_scanner,
                         const Layout& layout, const FrameViews& frames);

/// Likewise for each camera of a scan: puts the response into its scanner, where that is known, so
/// that what looks at the scan next corrects phases for it. Returns that of the first camera.
GammaChoice choose_response(Scan& scan, const std::string& how);

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
