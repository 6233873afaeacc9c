#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `reproduce`, which recomputes the tables and figures of the dissertation.
void add_reproduce(const Commands& program);

/// Adds `bench`, which times every stage on this machine.
void add_bench(const Commands& program);

}  // namespace slipstream::app
