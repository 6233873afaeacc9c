#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `frame points`, `frame planes`, `frame board` and `frame marker`, which find the pose of a
/// frame in a scan.
void add_found_frames(const Commands& frame);

}  // namespace slipstream::app
