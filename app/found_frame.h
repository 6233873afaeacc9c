#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `frame points`, `frame planes` and `frame board`, which find the pose of a frame in a scan.
void add_found_frames(const Commands& frame);

}  // namespace slipstream::app
