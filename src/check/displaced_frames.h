#pragma once

#include <optional>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Detects frames that are displaced against each other, as if camera, projector or object moved
/// between them: one displacement for each frame explains the residual. nullopt if it does not, or
/// if the scene may move. `fit`: the result of fit_of.
std::optional<Finding> displaced_frames(const JudgedScan& scan, const Fit& fit);

}  // namespace slipstream
