#pragma once

#include <string>

#include "python/bindings/arguments.h"
#include "python/bindings/bindings.h"
#include "slipstream/virtual_world.h"

namespace slipstream::python {

/// Adds the virtual world, whose scans are those of bind_scans.
void bind_virtual_world(py::module_& module);

/// Takes the keywords of `simulate`.
VirtualWorld world_from(Keywords& keywords);

/// Their entries in a docstring, except `scanner`.
std::string world_help();

}  // namespace slipstream::python
