#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `slipstream camera serve`, in programs built with Aravis.
void add_camera_serve(CLI::App& camera, Command& chosen);

}  // namespace slipstream::app
