#pragma once

#include <filesystem>
#include <optional>

#include "slipstream/cloud.h"

namespace slipstream {

/// RMS error of depth, mm, against the ground truth of a virtual scan, truth/depth.tiff, over the
/// points in both; at edges against the nearest depth around the pixel. Returns nullopt without
/// ground truth or common points. Throws Error if the sizes differ.
std::optional<double> error_against_truth(const std::filesystem::path& folder, const Cloud& cloud);

}  // namespace slipstream
