#pragma once

#include <optional>

#include "reconstruct/epipolar.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Coordinates along x and y that do not meet in one projector pixel: in over a third of the
/// points, which makes all of them unsure, or by a common distance, which is an error of the
/// calibration.
std::optional<Finding> axes_that_disagree(const EpipolarCheck& check, double calibration_rms);

/// Camera and projector that do not stand as in the scanner, by a scan's guard; or a guard that
/// cannot tell.
std::optional<Finding> rig_that_moved(const Scanner& scanner, const GuardCheck& guard);

}  // namespace slipstream
