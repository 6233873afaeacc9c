#pragma once

#include <string>
#include <vector>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream::python {
namespace py = pybind11;

/// Keyword arguments, taken one by one.
class Keywords {
 public:
  explicit Keywords(const py::kwargs& given) : left_(given.attr("copy")()) {}

  /// Where it was given. Throws TypeError for what is no such value.
  template <class Value>
  void take(const char* name, Value& value) {
    known_.emplace_back(name);
    if (!left_.contains(name)) return;
    const py::object given = left_.attr("pop")(name);
    try {
      value = given.cast<Value>();
    } catch (const py::cast_error&) {
      refuse(name, given);
    }
  }
  /// Throws TypeError, and says what was meant, where any is left.
  void require_none_left() const;

 private:
  [[noreturn]] static void refuse(const char* name, const py::object& given);

  py::dict left_;
  std::vector<std::string> known_;
};

/// Those of ReconstructSettings, FringeOrderConsensus and CleanSettings by the names they have
/// there; `backend` as set_backend names it, and `raw` for no cleaning and no range of depth.
void take(Keywords& keywords, ReconstructSettings& settings);
ReconstructSettings reconstruct_settings(const py::kwargs& given);

/// Those of CleanSettings alone.
CleanSettings clean_settings(const py::kwargs& given);

}  // namespace slipstream::python
