#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "slipstream/capture/frame_set.h"
#include "slipstream/gamma/blind.h"
#include "slipstream/gamma/response.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/phase/phase_correction.h"

namespace slipstream::app {

/// How the phase of a scan is corrected, and what is to be said of it.
struct GammaChoice {
  PhaseCorrections corrections = {};
  std::string source = "none";       ///< "scanner file", "blind", "given", "two cameras" or "none"
  std::optional<double> gamma = {};  ///< nothing for a measured curve
  std::optional<BlindGamma> blind = {};
  std::string sentence;  ///< for people; empty where nothing was corrected or asked for
};

/// As the JSON document says it: `source`, and where there is one `gamma`, `standard_error`,
/// `pixels`, `refused`.
nlohmann::json json_of(const GammaChoice& choice);

/// `--gamma`: "scanner" (what the scanner file says, if it does), "blind" (from the frames
/// themselves), "none", or a number. Throws Error for anything else.
GammaChoice choose_gamma(const std::string& flag, const ScanDescription& scan,
                         const FrameSet& frames);

/// The same before there are frames, so that "blind" is refused. `of_scanner`: the response that
/// the scanner file holds, if it does.
GammaChoice choose_gamma(const std::string& flag, const std::optional<Response>& of_scanner,
                         const std::vector<int>& steps);

}  // namespace slipstream::app
