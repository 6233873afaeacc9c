#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slipstream/camera/camera_description.h"
#include "slipstream/camera/camera_settings.h"
#include "slipstream/capture/frame_source.h"

namespace slipstream {

/// Opens an AravisSource. Throws as it does; Error in builds without Aravis.
std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name,
                                                 const CameraSettings& settings);

/// GenICam cameras that answer, on all networks and USB; their names are as AravisSource takes
/// them. Takes about a second. None in builds without Aravis.
std::vector<CameraDescription> list_genicam_cameras();

}  // namespace slipstream
