#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `merge`, which joins views to one model.
void add_merge(const Commands& program);

}  // namespace slipstream::app
