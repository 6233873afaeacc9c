#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/response.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/response/harmonics.h"

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

}  // namespace slipstream
