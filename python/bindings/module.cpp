#include <filesystem>
#include <optional>

#include <tbb/global_control.h>

#include "python/bindings/bindings.h"
#include "slipstream/error/error.h"

namespace slipstream::python {
namespace {

/// While it is entered as many threads at most work on one call.
class Threads {
 public:
  explicit Threads(std::size_t most) : most_(most) {
    if (most == 0) throw Error("threads: 1 or more");
  }
  void enter() { limit_.emplace(tbb::global_control::max_allowed_parallelism, most_); }
  void exit() { limit_.reset(); }

 private:
  std::size_t most_;
  std::optional<tbb::global_control> limit_;
};

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
  py::class_<Threads>(module, "threads",
                      "with threads(1): each call works on so many threads at most.")
      .def(py::init<std::size_t>(), py::arg("most"))
      .def("__enter__", [](Threads& threads) { threads.enter(); })
      .def("__exit__", [](Threads& threads, const py::args&) { threads.exit(); });
  bind_scanners(module);
  bind_scans(module);
  bind_clouds(module);
  bind_engine(module);
  bind_virtual_world(module);
  bind_calibration(module);
  bind_live(module);
  module.attr("__version__") = SLIPSTREAM_VERSION;
}
