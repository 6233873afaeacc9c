#pragma once

#include <optional>

#include "check/scan_samples.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Detects frames of noise, in which neighbouring pixels do not change together. Requires at least
/// `fewest_groups`.
std::optional<Finding> unrelated_pixels(const ScanSamples& samples);

}  // namespace slipstream
