#pragma once

#include <vector>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Warnings about what frames that fit cannot show, or measure badly.
std::vector<Finding> method_limits(const JudgedScan& scan, const Fit& fit);

}  // namespace slipstream
