#pragma once

#include "python/bindings/bindings.h"

namespace slipstream::python {

/// Adds strategies and sequences.
void bind_sequences(py::module_& module);

}  // namespace slipstream::python
