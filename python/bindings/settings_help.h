#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "python/bindings/bindings.h"
#include "slipstream/engine.h"
#include "slipstream/setting.h"

namespace slipstream::python {

// Types of settings as docstrings and the stub write them.
inline std::string type_name(bool /*value*/) {
  return "bool";
}

inline std::string type_name(int /*value*/) {
  return "int";
}

inline std::string type_name(std::uint64_t /*value*/) {
  return "int";
}

inline std::string type_name(double /*value*/) {
  return "float";
}

inline std::string type_name(const PointBox& /*value*/) {
  return "tuple[typing.Sequence[float], typing.Sequence[float]]";
}

inline std::string type_name(const std::vector<PictureCorner>& /*value*/) {
  return "typing.Sequence[tuple[float, float]]";
}

template <class Value>
std::string type_name(const std::optional<Value>& /*value*/) {
  return type_name(Value()) + " | None";
}

/// An entry of a docstring's `Args:` for a keyword and its default.
template <class Value>
std::string keyword_help(const std::string& name, const std::string& type, const Value& usual,
                         const std::string& help) {
  const auto shown = py::repr(py::cast(usual)).template cast<std::string>();
  return fmt::format("{} ({}, default {}):\n    {}\n", name, type, shown, help);
}

/// The entries of all settings that a struct describes, see Setting, with their present values as
/// defaults.
template <class Settings>
std::string described_help(const Settings& settings) {
  std::string entries;

  Settings::for_each_setting(settings, [&](const Setting& setting, const auto& value) {
    // An option that clears its setting has the help of the opposite.
    const std::string help = setting.option_clears ? "False: " : "";
    entries += keyword_help(setting.name, type_name(value), value, help + setting.help);
  });

  return entries;
}

/// The entries of the keywords that `take` accepts for these settings.
std::string reconstruct_help();

/// The docstring with these entries in place of its line `{settings}`, indented like that line.
std::string with_settings(const std::string& entries, const std::string& docstring);

}  // namespace slipstream::python
