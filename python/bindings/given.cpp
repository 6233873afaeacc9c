#include "python/bindings/given.h"

#include <filesystem>
#include <string>

#include "python/bindings/bindings.h"
#include "python/bindings/scans.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner_file.h"

namespace slipstream::python {

bool is_path(py::handle given) {
  return py::isinstance<py::str>(given) || py::hasattr(given, "__fspath__");
}

bool take_given(py::handle given, Given<Strategy>& strategy) {
  strategy.name = "strategy";

  if (py::isinstance<py::str>(given)) {
    strategy.value = strategy_labelled(given.cast<std::string>());
    return true;
  }

  if (!py::isinstance<Strategy>(given)) return false;
  strategy.value = given.cast<Strategy>();
  return true;
}

bool take_given(py::handle given, Given<Sequence>& sequence) {
  sequence.name = "sequence";

  if (py::isinstance<Sequence>(given)) {
    sequence.value = given.cast<Sequence>();
    return true;
  }

  // Its patterns along x, with the usual light.
  Given<Strategy> strategy;
  if (!take_given(given, strategy)) return false;
  sequence.value = {.strategy = strategy.value};
  return true;
}

bool take_given(py::handle given, Given<Scanner>& scanner) {
  scanner.name = "scanner";

  if (py::isinstance<Scanner>(given)) {
    scanner.value = given.cast<Scanner>();
    return true;
  }

  if (!is_path(given)) return false;
  const auto path = given.cast<fs::path>();
  scanner.value = unlocked([&] { return read_scanner(path); });
  scanner.name = path.string();
  return true;
}

bool take_given(py::handle given, Given<Scan>& scan) {
  scan.name = "scan";

  if (py::isinstance<Scan>(given)) {
    scan.value = given.cast<Scan>();
    return true;
  }

  if (!is_path(given)) return false;
  const auto path = given.cast<fs::path>();
  scan.value = unlocked([&] { return load_scan(path); });
  scan.name = path.string();
  warn_of_files(scan.value);
  return true;
}

}  // namespace slipstream::python
