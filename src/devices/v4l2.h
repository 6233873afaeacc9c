#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "devices/video_device.h"
#include "slipstream/camera.h"

namespace slipstream {

/// Opens a camera through V4L2; `name` is used in messages. Sequence number and device time come
/// from the driver, so that dropped frames are noticed. An unplugged camera is reopened when it is
/// back. Throws Error if it refuses a setting, WorldError if it does not answer.
std::unique_ptr<FrameSource> open_v4l2_camera(
    const std::string& name, const std::function<std::unique_ptr<VideoDevice>()>& open,
    const CameraSettings& settings);

/// V4L2 cameras of this machine; their names are numbers.
std::vector<CameraDescription> list_v4l2_cameras();

}  // namespace slipstream
