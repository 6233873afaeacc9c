#pragma once

#include <vector>

#include "reconstruct/epipolar.h"
#include "slipstream/finding.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// The simple changes since the calibration that explain the distances of a guard's pixels from
/// their epipolar lines: camera or projector turned, moved or zoomed, pictures turned, mirrored or
/// cropped. Up to three, the best first; empty if none does. A flat scene does not tell all of them
/// apart.
std::vector<Cause> rig_motions(const Scanner& scanner, const GuardCheck& guard);

}  // namespace slipstream
