#pragma once

#include "python/bindings/bindings.h"

namespace slipstream::python {

/// Adds findings, and the check that makes them of the scans of bind_scans.
void bind_findings(py::module_& module);

}  // namespace slipstream::python
