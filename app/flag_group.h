#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <CLI/App.hpp>

namespace slipstream::app {

/// What the help shows for the value of a flag that names a file or a folder to read.
inline constexpr const char* file_type = "FILE";
/// The same of a file to write.
inline constexpr const char* output_type = "OUTPUT";
/// The same of a scanner file to write, which may be the one that is read and added to.
inline constexpr const char* scanner_output_type = "SCANNER";

/// Why the text is no number that a flag takes; empty where it is one. Nothing wants NaN.
std::string why_no_number(const std::string& text, bool is_unsigned, bool is_whole);

/// The type of the numbers that go into a flag's value.
template <class Value>
struct NumberOf {
  using Type = Value;
};
template <class Value>
struct NumberOf<std::optional<Value>> : NumberOf<Value> {};
template <class Value>
struct NumberOf<std::vector<Value>> : NumberOf<Value> {};

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
      using Number = typename NumberOf<Value>::Type;
      if constexpr (std::is_arithmetic_v<Number>) {
        option->check([option](const std::string& text) {
          const bool left_out = option->get_expected_min() == 0 && text.empty();
          return left_out
                     ? ""
                     : why_no_number(text, std::is_unsigned_v<Number>, std::is_integral_v<Number>);
        });
      }
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

  /// The same of a file to write, which no other flag may name.
  template <class Value>
  CLI::Option* add_output(const std::string& flag, Value& value, const std::string& help) const {
    return add(flag, value, help)->type_name(output_type);
  }

  /// The same of a scanner file to write.
  template <class Value>
  CLI::Option* add_scanner_output(const std::string& flag, Value& value,
                                  const std::string& help) const {
    return add(flag, value, help)->type_name(scanner_output_type);
  }
};

}  // namespace slipstream::app
