#pragma once

#include <string>
#include <vector>

#include <pybind11/pybind11.h>

#include "slipstream/check/checked_scan.h"
#include "slipstream/scan/scan.h"

namespace slipstream::python {

/// As warnings.warn, each as "NAME: LINE", or the line alone where there is no name.
void warn_of(const std::string& name, const std::vector<std::string>& lines);

/// Warns of findings and repairs; throws Error where something is wrong, unless `anyway`.
void refuse_or_warn(const CheckedScan& checked, const std::string& name, bool anyway);

/// A Scan, or the path of one, checked and put in order. `of_gamma`: what blames the response is no
/// finding. Throws Error where it is refused.
Scan checked_scan(const pybind11::handle& scan, bool of_gamma);

}  // namespace slipstream::python
