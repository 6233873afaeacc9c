#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "slipstream/frame_set.h"
#include "slipstream/layout.h"
#include "slipstream/response.h"
#include "slipstream/scan.h"

namespace slipstream {

/// Why gamma cannot be determined from a scan.
enum class BlindRefusal {
  none,
  too_few_pixels,  ///< lit and unsaturated ones
  ambient_light,   ///< N = 3: it affects A / B as gamma does
  no_distortion,   ///< gamma is 1 within its uncertainty
  no_power_law,    ///< no gamma in range fits
};

/// A sentence without a full stop.
std::string_view reason_of(BlindRefusal refusal);

/// Gamma estimated from one scan alone.
struct BlindGamma {
  BlindRefusal refusal = BlindRefusal::none;
  double gamma = 1;           ///< the best fit, even if refused
  double standard_error = 0;  ///< if the pixels' errors are independent
  std::size_t pixels = 0;     ///< number of pixels used

  /// Whether to correct with it.
  [[nodiscard]] bool accepted() const { return refusal == BlindRefusal::none; }
};

/// The response that a scan's phases are corrected for, and its origin.
struct GammaChoice {
  std::optional<MeasuredResponse> response{};  ///< nullopt: no correction
  std::string source = "none";    ///< "scanner file", "blind", "given", "two cameras" or "none"
  std::optional<double> gamma{};  ///< nullopt for a measured curve; set even if refused
  std::optional<BlindGamma> blind{};
  std::string sentence{};  ///< for the user; empty unless corrected or requested
};

/// `how`: "scanner" (the scanner's response, if any), "none", or a number. Throws Error for
/// anything else; for "blind" the message says that it requires a scan.
GammaChoice choose_gamma(const std::string& how, const std::optional<MeasuredResponse>& of_scanner);

/// Also accepts "blind": estimates gamma from the frames, using the scan's run of steps with the
/// smallest standard error.
GammaChoice choose_gamma(const std::string& how, const std::optional<MeasuredResponse>& of_scanner,
                         const Layout& layout, const FrameViews& frames);

/// Does this for each camera of a scan, and stores the response in its scanner, if known, so that
/// later processing corrects phases for it. Returns the first camera's choice.
GammaChoice choose_response(Scan& scan, const std::string& how);

}  // namespace slipstream
