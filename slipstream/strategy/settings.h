#pragma once

#include <map>
#include <optional>
#include <string>

namespace slipstream {

/// Settings of a strategy by the names that struct, scan.yaml and command line share.
using StrategySettings = std::map<std::string, double>;

/// What a coding's struct holds, by for_each_setting: see Strategy. An optional that is empty is
/// left out.
template <class Coding>
StrategySettings settings_from(const Coding& coding) {
  StrategySettings settings;
  Coding::for_each_setting(coding, [&](const char* name, const char*, const auto& value) {
    if constexpr (requires { value.has_value(); }) {
      if (value) settings[name] = static_cast<double>(*value);
    } else {
      settings[name] = static_cast<double>(value);
    }
  });
  return settings;
}

}  // namespace slipstream
