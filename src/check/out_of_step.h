#pragma once

#include <optional>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "slipstream/finding.h"

namespace slipstream {

/// A diagnostic of frames that contain a share of the pattern before, and the misfit without it.
struct MixedFrames {
  double misfit = 0;
  Finding finding;
};

/// nullopt unless such a share explains what does not fit.
std::optional<MixedFrames> mixed_frames(const JudgedScan& scan, const Fit& as_given);

}  // namespace slipstream
