#pragma once

#include "python/bindings/bindings.h"

namespace slipstream::python {

/// Adds the calibrations; uses the types of bind_scanners and bind_scans.
void bind_calibration(py::module_& module);

}  // namespace slipstream::python
