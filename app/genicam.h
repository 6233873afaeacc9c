#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "app/camera_flags.h"
#include "app/commands.h"
#include "slipstream/capture/camera_description.h"
#include "slipstream/capture/frame_source.h"

namespace slipstream::app {

/// The GenICam camera of that name or address, the first found where it is empty, for patterns in
/// cycles of so many. Throws Error where the program was built without Aravis.
std::unique_ptr<FrameSource> open_genicam_camera(const std::string& name, const CameraFlags& flags,
                                                 std::optional<double> rate, int cycle);

/// What answers; nothing where the program was built without Aravis.
std::vector<CameraDescription> genicam_cameras();

/// Adds `slipstream camera serve`, where the program was built with Aravis.
void add_camera_serve(CLI::App& camera, SharedFlags& shared, Command& chosen);

}  // namespace slipstream::app
