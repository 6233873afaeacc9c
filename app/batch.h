#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `batch plan`, `batch run` and `batch merge`: many scans on many machines.
void add_batch(const Commands& program);

}  // namespace slipstream::app
