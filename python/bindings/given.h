#pragma once

#include <string>

#include <pybind11/pybind11.h>

#include "slipstream/scan.h"
#include "slipstream/scanner.h"
#include "slipstream/sequence.h"
#include "slipstream/strategy.h"

namespace slipstream::python {

/// An argument that users give as the thing itself or by its name: a Strategy by its label, a
/// Sequence by its Strategy or label, a Scanner by its file, a Scan by its folder or
/// recording.
template <class Value>
struct Given {
  Value value{};
  std::string name{};  ///< in messages: the path, or "scan" and the like
};

/// Whether it is a str or a PathLike.
bool is_path(pybind11::handle given);

// Each returns false for an object of another type. Throws Error for an unknown label or an
// unreadable file. A scan that is read warns as load_scan does.
bool take_given(pybind11::handle given, Given<Strategy>& strategy);
bool take_given(pybind11::handle given, Given<Sequence>& sequence);
bool take_given(pybind11::handle given, Given<Scanner>& scanner);
bool take_given(pybind11::handle given, Given<Scan>& scan);

}  // namespace slipstream::python

namespace pybind11::detail {

template <class Value>
struct type_caster<slipstream::python::Given<Value>> {
  PYBIND11_TYPE_CASTER(slipstream::python::Given<Value>, make_caster<Value>::name);

  bool load(handle source, bool /*convert*/) {
    return slipstream::python::take_given(source, value);
  }
};

}  // namespace pybind11::detail
