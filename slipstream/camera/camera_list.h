#pragma once

#include <vector>

#include "slipstream/capture/camera_description.h"

namespace slipstream {

/// GenICam cameras that answer, on all networks and USB. Takes about a second.
std::vector<CameraDescription> list_genicam_cameras();

}  // namespace slipstream
