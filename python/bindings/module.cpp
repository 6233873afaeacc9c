#include <exception>
#include <filesystem>
#include <string>

#include <tbb/global_control.h>

#include "base/system_failure.h"
#include "python/bindings/arguments.h"
#include "python/bindings/bindings.h"
#include "python/bindings/clouds.h"
#include "python/bindings/scans.h"
#include "slipstream/check.h"
#include "slipstream/error.h"

namespace slipstream::python {
namespace {

/// File names too long or circular links become bad input; a refused scan an Error with its
/// findings. All messages get the module's names, and the next translator reports them.
void translate(std::exception_ptr failure) try {
  if (failure) std::rethrow_exception(failure);
} catch (const std::filesystem::filesystem_error& error) {
  const std::string message = error.path1().string() + ": " + error.code().message();
  if (is_system_failure(error.code().value())) throw WorldError(message);
  throw Error(message);
} catch (const RefusedScan& refused) {
  const py::object type = py::module_::import("slipstream").attr("Error");
  const py::object error = type(with_keywords(refused.what()));
  error.attr("findings") = refused.findings();
  PyErr_SetObject(type.ptr(), error.ptr());
} catch (const Error& error) {
  throw Error(with_keywords(error.what()));
} catch (const WorldError& error) {
  throw WorldError(with_keywords(error.what()));
}

/// False for an object whose constructor failed, which debuggers may still see.
bool is_constructed(const py::object& object) {
  auto* const instance = reinterpret_cast<py::detail::instance*>(object.ptr());
  return instance->get_value_and_holder().value_ptr() != nullptr;
}

void bind_errors(py::module_& module) {
  auto& error = py::register_exception<Error>(module, "Error", PyExc_ValueError);
  error.attr("__doc__") =
      "Bad input; one line with the problem and its remedy. If a scan is refused, `findings` has "
      "its findings, else it is empty.";
  error.attr("findings") = py::list();

  auto& world_error = py::register_exception<WorldError>(module, "WorldError", PyExc_OSError);
  world_error.attr("__doc__") =
      "A system failure: disk full, folder not writable, camera disconnected.";

  py::register_exception_translator(translate);
}

}  // namespace
}  // namespace slipstream::python

PYBIND11_MODULE(_slipstream, module) {
  using namespace slipstream::python;

  // Types belong to the package that users import, and signatures show that name.
  const py::object own_name = module.attr("__name__");
  module.attr("__name__") = "slipstream";

  bind_errors(module);

  // For the package's Python files.
  module.def("_shown", &shown);
  module.def("_with_keywords", &with_keywords);
  module.def("_is_constructed", &is_constructed);

  py::class_<tbb::global_control>(module, "_ThreadLimit").def(py::init([](std::size_t most) {
    if (most == 0) throw slipstream::Error("threads: 1 or more");
    return new tbb::global_control(tbb::global_control::max_allowed_parallelism, most);
  }));

  // In this order: later parts use the types of earlier ones.
  bind_sequences(module);
  bind_scanners(module);
  bind_scans(module);
  bind_findings(module);
  bind_clouds(module);
  bind_map_files(module);
  bind_spatial_unwrapping(module);
  bind_engine(module);
  bind_virtual_world(module);
  bind_calibration(module);
  bind_live(module);

  module.attr("__version__") = SLIPSTREAM_VERSION;
  module.attr("__name__") = own_name;
}
