#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "slipstream/capture/frame_set.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/phase/phase_correction.h"

namespace slipstream::app {

/// How the phase of a scan is corrected, and what is to be said of it.
struct GammaChoice {
  PhaseCorrections corrections;
  nlohmann::json
      document;          ///< `source`, and where there is one `gamma`, `standard_error`, `refused`
  std::string sentence;  ///< for people; empty where nothing was corrected or asked for
};

/// `--gamma`: "scanner" (what the scanner file says, if it does), "blind" (from the frames
/// themselves), "none", or a number. Throws Error for anything else.
GammaChoice choose_gamma(const std::string& flag, const ScanDescription& scan,
                         const FrameSet& frames);

}  // namespace slipstream::app
