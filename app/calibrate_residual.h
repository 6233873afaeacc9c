#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `calibrate residual`, which maps a lens model's remainder by a scan along both axes.
void add_calibrate_residual(const Commands& calibrate);

}  // namespace slipstream::app
