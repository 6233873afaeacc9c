#pragma once

#include <optional>

#include "check/scan_samples.h"
#include "slipstream/finding.h"
#include "slipstream/layout.h"

namespace slipstream {

/// Detects grey levels that wrapped around: beyond the highest one they begin again at 0, as in
/// arithmetic with 8-bit integers. nullopt for codes alone, whose levels jump anyway.
std::optional<Finding> wrapped_levels(const Layout& layout, const ScanSamples& samples);

}  // namespace slipstream
