#pragma once

#include <pybind11/pybind11.h>

namespace slipstream::python {

// What each file of this folder adds to the module; those that follow use the types of those
// before.
void bind_strategies(pybind11::module_& module);
void bind_scanners(pybind11::module_& module);
void bind_scans(pybind11::module_& module);
void bind_clouds(pybind11::module_& module);
void bind_engine(pybind11::module_& module);
void bind_virtual_world(pybind11::module_& module);
void bind_photometry(pybind11::module_& module);
void bind_calibration(pybind11::module_& module);
void bind_recordings(pybind11::module_& module);
void bind_live(pybind11::module_& module);

}  // namespace slipstream::python
