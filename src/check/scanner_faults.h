#pragma once

#include <optional>
#include <vector>

#include "slipstream/finding.h"
#include "slipstream/frame_set.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Finds files in metres, swapped devices, another picture size. `whole_pictures`: false if the
/// camera's pictures are cropped or rectified, so that the optical axis may lie anywhere.
std::vector<Finding> check_scanner(const Scanner& scanner, bool whole_pictures = true);

/// Finds pictures of a region of the sensor that were padded to its full size: they end in a border
/// of one level, but the optical axis lies in the middle of whole pictures.
std::optional<Finding> padded_pictures(const FrameViews& frames, const Lens& camera);

}  // namespace slipstream
