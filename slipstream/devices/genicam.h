#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slipstream/devices/camera_description.h"
#include "slipstream/devices/camera_settings.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// Opens the GenICam camera of that name (see list_genicam_cameras), serial number or network
/// address; the first one found where it is empty. Frames are numbered by the camera, from 0 at the
/// start, and timed by its clock. A camera that is gone is sought until it is back; letting go of
/// one that is gone takes some seconds. Throws Error where it does not take a setting and in builds
/// without Aravis, WorldError where it does not answer.
std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name,
                                                 const CameraSettings& settings);

/// GenICam cameras that answer, on all networks and USB; their names are as they are opened
/// by. Takes about a second. None in builds without Aravis.
std::vector<CameraDescription> list_genicam_cameras();

}  // namespace slipstream
