#pragma once

#include <optional>
#include <string_view>

#include "slipstream/camera/camera_settings.h"

namespace slipstream {

/// The region that "640x480+16+8" says, width x height + x + y, or "640x480", which begins at 0, 0;
/// none for any other text.
std::optional<CameraRegion> region_of_text(std::string_view text);

}  // namespace slipstream
