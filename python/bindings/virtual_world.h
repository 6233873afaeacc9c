#pragma once

#include <string>

#include "python/bindings/arguments.h"
#include "slipstream/virtual_world.h"

namespace slipstream::python {

/// Takes the keywords of `simulate`.
VirtualWorld world_from(Keywords& keywords);

/// Their entries in a docstring, except `scanner`.
std::string world_help();

}  // namespace slipstream::python
