#pragma once

#include "python/bindings/bindings.h"

namespace slipstream::python {

/// Adds live reconstruction; uses the types of bind_scans and bind_clouds.
void bind_live(py::module_& module);

}  // namespace slipstream::python
