#pragma once

#include <vector>

#include "slipstream/finding.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Finds files in metres, swapped devices, another picture size. `whole_pictures`: false if the
/// camera's pictures are cropped or rectified, so that the optical axis may lie anywhere.
std::vector<Finding> check_scanner(const Scanner& scanner, bool whole_pictures = true);

}  // namespace slipstream
