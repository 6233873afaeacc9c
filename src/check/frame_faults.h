#pragma once

#include <optional>
#include <vector>

#include "check/frame_model.h"
#include "check/scan_samples.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Finds a frame that contains only ambient light: nearly uniform, and almost nowhere brighter than
/// the darkest other frame. A pattern that is dark wherever the scene lies looks the same. Requires
/// at least `fewest_groups`.
std::optional<Finding> without_pattern(const ScanSamples& samples, int n);

/// Finds lighting that prevents or degrades measurement: no, too little or too much light, ambient
/// light stronger than the projector's, or fewer bits than declared. `bits`: declared camera bits,
/// 0 of unquantised frames; `least_modulation`: minimum of a point, grey levels of 255.
std::vector<Finding> light_faults(const FrameModel& model, const ScanSamples& samples, int bits,
                                  double least_modulation);

}  // namespace slipstream
