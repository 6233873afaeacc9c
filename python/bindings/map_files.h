#pragma once

#include "python/bindings/arguments.h"

namespace slipstream::python {

/// Adds reading and writing of maps.
void bind_map_files(py::module_& module);

/// Adds spatial phase unwrapping.
void bind_spatial_unwrapping(py::module_& module);

}  // namespace slipstream::python
