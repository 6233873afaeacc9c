#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `convert`, which converts clouds, scans and frames to other file formats.
void add_convert(const Commands& program);

}  // namespace slipstream::app
