#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `verify`, the acceptance test with certified artefacts.
void add_verify(const Commands& program);

/// Adds `compare`, which compares strategies in the virtual world.
void add_compare(const Commands& program);

}  // namespace slipstream::app
