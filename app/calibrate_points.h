#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `calibrate points`, which calibrates from points that another program found.
void add_calibrate_points(const Commands& calibrate);

}  // namespace slipstream::app
