#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `simulate`, which takes a scan with the virtual scanner.
void add_simulate(const Commands& program);

}  // namespace slipstream::app
