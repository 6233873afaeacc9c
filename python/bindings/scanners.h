#pragma once

#include "python/bindings/bindings.h"

namespace slipstream::python {

/// Adds response curves and scanners.
void bind_scanners(py::module_& module);

}  // namespace slipstream::python
