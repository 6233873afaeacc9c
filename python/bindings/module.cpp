#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>

#include <tbb/global_control.h>

#include "python/bindings/calibration.h"
#include "python/bindings/clouds.h"
#include "python/bindings/engines.h"
#include "python/bindings/scanners.h"
#include "python/bindings/scans.h"
#include "slipstream/check.h"
#include "slipstream/error.h"

namespace slipstream::python {
namespace {

/// Replaces the docstring of a function, which Python cannot.
void document(const py::handle& function, const std::string& text) {
  PyMethodDef* const method = reinterpret_cast<PyCFunctionObject*>(function.ptr())->m_ml;
  std::free(const_cast<char*>(method->ml_doc));  // allocated so by pybind11
  method->ml_doc = ::strdup(text.c_str());
}

/// File names too long or circular links become bad input, reported by the next translator; a
/// refused scan an Error with its findings.
void translate(std::exception_ptr failure) try {
  if (failure) std::rethrow_exception(failure);
} catch (const std::filesystem::filesystem_error& error) {
  throw Error(error.path1().string() + ": " + error.code().message());
} catch (const RefusedScan& refused) {
  const py::object type = py::module_::import("slipstream").attr("Error");
  const py::object error = type(refused.what());
  error.attr("findings") = refused.findings();
  PyErr_SetObject(type.ptr(), error.ptr());
}

}  // namespace
}  // namespace slipstream::python

PYBIND11_MODULE(_slipstream, module) {
  using namespace slipstream::python;

  // A refused scan has its findings, any other error none.
  py::register_exception<slipstream::Error>(module, "Error", PyExc_ValueError).attr("findings") =
      py::list();
  py::register_exception<slipstream::WorldError>(module, "WorldError", PyExc_OSError);
  py::register_exception_translator(translate);

  py::class_<tbb::global_control>(module, "_ThreadLimit").def(py::init([](std::size_t most) {
    if (most == 0) throw slipstream::Error("threads: 1 or more");
    return new tbb::global_control(tbb::global_control::max_allowed_parallelism, most);
  }));

  module.def("_document", &document);

  // In this order: later parts use the types of earlier ones.
  bind_scanners(module);
  bind_scans(module);
  bind_clouds(module);
  bind_engine(module);
  bind_virtual_world(module);
  bind_calibration(module);
  bind_live(module);

  module.attr("__version__") = SLIPSTREAM_VERSION;
}
