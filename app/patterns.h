#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `patterns`, which writes the patterns of a strategy as pictures.
void add_patterns(const Commands& program);

/// Adds `design`, which finds the patterns with the least noise.
void add_design(const Commands& program);

}  // namespace slipstream::app
