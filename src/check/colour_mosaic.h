#pragma once

#include <optional>

#include "check/scan_samples.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Finds pixels whose gain alternates like the green ones of a Bayer filter.
std::optional<Finding> colour_mosaic(const ScanSamples& samples);

}  // namespace slipstream
