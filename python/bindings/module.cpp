#include <filesystem>

#include <tbb/global_control.h>

#include "python/bindings/bindings.h"
#include "slipstream/base/error.h"

namespace slipstream::python {
namespace {

/// A name too long, links in a ring: bad input, which the next translator tells.
void translate(std::exception_ptr failure) {
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const std::filesystem::filesystem_error& error) {
    throw Error(error.path1().string() + ": " + error.code().message());
  }
}

}  // namespace
}  // namespace slipstream::python

PYBIND11_MODULE(_slipstream, module) {
  using namespace slipstream::python;
  py::register_exception<slipstream::Error>(module, "Error", PyExc_ValueError).attr("__doc__") =
      "Bad input; one line says what is wrong and what would be right.";
  py::register_exception<slipstream::WorldError>(module, "WorldError", PyExc_OSError)
      .attr("__doc__") = "A failure of the world: disk full, folder not writable, camera gone.";
  py::register_exception_translator(translate);
  py::class_<tbb::global_control>(module, "_ThreadLimit").def(py::init([](std::size_t most) {
    if (most == 0) throw slipstream::Error("threads: 1 or more");
    return new tbb::global_control(tbb::global_control::max_allowed_parallelism, most);
  }));
  bind_scanners(module);
  bind_scans(module);
  bind_clouds(module);
  bind_engine(module);
  bind_virtual_world(module);
  bind_calibration(module);
  bind_live(module);
  module.attr("__version__") = SLIPSTREAM_VERSION;
}
