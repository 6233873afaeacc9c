#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/cloud/clean_settings.h"
#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// 1 for the pixels inside an outline, see CleanSettings.
Image<std::uint8_t> outline_mask(const std::vector<PictureCorner>& outline, Size picture);

bool is_inside(const PointBox& box, const Cloud& cloud, int column, int row);

}  // namespace slipstream
