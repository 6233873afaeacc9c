#pragma once

#include <optional>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Detects one frame that contradicts all others, as if it were blurred, shaken or lit by other
/// light; names several if the patterns cannot tell which of them. nullopt if the others contradict
/// each other as well. `fit`: the result of fit_of.
std::optional<Finding> contradicting_frame(const JudgedScan& scan, const Fit& fit);

/// Frames that contradict each other by more than a waveform, a single frame or a displacement of
/// whole frames explains. Only of a single band of four steps or more whose response is known to be
/// linear.
std::optional<Finding> contradicting_frames(const JudgedScan& scan, const Fit& fit);

}  // namespace slipstream
