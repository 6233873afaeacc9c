#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `assist`, which recommends exposures.
void add_assist(const Commands& program);

}  // namespace slipstream::app
