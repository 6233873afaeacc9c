#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `demo`, a scan of the virtual world and its reconstruction.
void add_demo(const Commands& program);

}  // namespace slipstream::app
