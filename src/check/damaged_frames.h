#pragma once

#include <vector>

#include "check/scan_samples.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Finds frames that are identical in whole or in part, or black from some row on.
std::vector<Finding> damaged_frames(const ScanSamples& samples);

}  // namespace slipstream
