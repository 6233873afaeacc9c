#pragma once

#include <vector>

#include "check/judged_scan.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Finds frames without any pattern, unless the scene lies in a dark part of it: if no frame is
/// `lost`, another frame must show that the scene reaches a bright part.
std::vector<Finding> dark_frames(const JudgedScan& scan, bool lost = false);

}  // namespace slipstream
