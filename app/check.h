#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `measure`, which measures points, distances, planes and spheres in a cloud.
void add_measure(const Commands& program);

/// Adds `check`, which checks that a scan can be reconstructed.
void add_check(const Commands& program);

}  // namespace slipstream::app
