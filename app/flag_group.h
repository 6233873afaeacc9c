#pragma once

#include <string>
#include <type_traits>

#include <CLI/App.hpp>

namespace slipstream::app {

/// What the help shows for the value of a flag that names a file or a folder to read.
inline constexpr const char* file_type = "FILE";

/// Flags of a subcommand that its help shows together.
struct FlagGroup {
  CLI::App& app;
  std::string name = "Options";  ///< the help's heading

  /// Adds a flag whose value goes into `value`, a switch where that is a bool. The help shows what
  /// a number or a text is before, as the default.
  template <class Value>
  CLI::Option* add(const std::string& flag, Value& value, const std::string& help) const {
    if constexpr (std::is_same_v<Value, bool>) {
      return app.add_flag(flag, value, help)->group(name);
    } else {
      CLI::Option* const option = app.add_option(flag, value, help)->group(name);
      constexpr bool has_default =
          std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string>;
      return has_default ? option->capture_default_str() : option;
    }
  }

  /// The same of a file or a folder to read: in a rig file its path is relative to that.
  template <class Value>
  CLI::Option* add_file(const std::string& flag, Value& value, const std::string& help) const {
    return add(flag, value, help)->type_name(file_type);
  }
};

}  // namespace slipstream::app
