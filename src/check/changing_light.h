#pragma once

#include <optional>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Detects light that changed between frames: one gain for each frame explains the residual.
/// nullopt if it did not. `fit`: the result of fit_of.
std::optional<Finding> flicker(const JudgedScan& scan, const Fit& fit);

}  // namespace slipstream
