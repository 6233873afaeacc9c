#pragma once

#include <memory>
#include <string>
#include <vector>

#include "slipstream/camera.h"

namespace slipstream {

/// Opens the GenICam camera of that name (see list_genicam_cameras), serial number or network
/// address; the first one found if empty. Frames are numbered by the camera, from 0 at the start,
/// and timed by its clock. A lost camera is searched for until it is back; closing a lost camera
/// takes seconds. Throws Error for a missing node, a refused setting or one that reads back
/// different (numbers: by over 1 %), WorldError without an answer.
std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name,
                                                 const CameraSettings& settings);

/// GenICam cameras that answer, on all networks and USB. Takes a second. Empty without Aravis.
std::vector<CameraDescription> list_genicam_cameras();

}  // namespace slipstream
