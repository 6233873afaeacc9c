#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `project`, which shows patterns on a monitor or a DLP projector; with SLIPSTREAM_VIEW.
void add_project(const Commands& program);

}  // namespace slipstream::app
