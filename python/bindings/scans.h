#pragma once

#include <string>
#include <utility>
#include <vector>

#include "python/bindings/arguments.h"
#include "python/bindings/bindings.h"
#include "slipstream/check.h"
#include "slipstream/scan.h"

namespace slipstream::python {

/// Calls warnings.warn for each line, as "NAME: LINE" or the line alone without a name.
void warn_of(const std::string& name, const std::vector<std::string>& lines);

/// Gives the warnings of a loaded scan's files, for each camera.
void warn_of_files(const Scan& scan);

/// Warns of diagnostics and repairs; throws Error if the scan is refused, unless `anyway`.
void refuse_or_warn(const CheckedScan& checked, const std::string& name, bool anyway);

/// Each of several scans or paths; a single one stands for itself. Throws TypeError for other
/// objects.
std::vector<py::object> each_scan(const py::object& scans);

/// A Scan, or one loaded from a path, checked and with its frames in order, and its name for
/// messages. `of_gamma`: ignores diagnostics that blame the response. Throws Error if it is
/// refused.
std::pair<Scan, std::string> checked_scan(const py::handle& scan, bool of_gamma);

}  // namespace slipstream::python
