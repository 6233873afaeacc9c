#pragma once

#include "python/bindings/bindings.h"

namespace slipstream::python {

/// Adds engines, whose results have the types of bind_clouds.
void bind_engine(py::module_& module);

}  // namespace slipstream::python
