#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `calibrate height`, which calibrates heights over a reference plane.
void add_calibrate_height(const Commands& calibrate);

/// Adds `height`, which measures heights over a reference plane.
void add_height(const Commands& program);

/// Adds `unwrap`, which unwraps a phase map spatially.
void add_unwrap(const Commands& program);

}  // namespace slipstream::app
