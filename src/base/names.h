#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace slipstream {

/// The enumerator with that name; `names` are in enumeration order. nullopt for unknown names.
template <class Value, std::size_t count>
std::optional<Value> value_named(std::string_view name,
                                 const std::array<std::string_view, count>& names) {
  for (std::size_t i = 0; i < count; ++i) {
    if (names[i] == name) return static_cast<Value>(i);
  }
  return std::nullopt;
}

}  // namespace slipstream
