#pragma once

#include <optional>
#include <vector>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "slipstream/finding.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Warnings about what frames that fit cannot show, or measure badly.
std::vector<Finding> method_limits(const JudgedScan& scan, const Fit& fit);

/// A warning if baseline or depth, mm, is smaller than lenses allow.
std::optional<Finding> small_scale(const Scanner& scanner, double median_depth);

}  // namespace slipstream
