#pragma once

#include <optional>
#include <string>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/response.h"
#include "slipstream/frames/frame_views.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/response/blind.h"

namespace slipstream {

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
