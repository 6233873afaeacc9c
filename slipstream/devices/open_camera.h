#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slipstream/devices/camera_description.h"
#include "slipstream/devices/camera_settings.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// Opens a camera by name: "aravis:NAME" as open_genicam_camera takes it (the first one found where
/// NAME is empty), or "v4l2:NUMBER" for /dev/video<NUMBER>. Throws Error for another name, a
/// setting that the camera does not take, or GenICam cameras in builds without Aravis; WorldError
/// where the camera does not answer.
std::unique_ptr<FrameSource> open_camera(const std::string& name, const CameraSettings& settings);

/// Cameras that answer, named as open_camera takes them. Takes about a second.
std::vector<CameraDescription> list_cameras();

}  // namespace slipstream
