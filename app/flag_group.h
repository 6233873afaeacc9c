#pragma once

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <CLI/App.hpp>

#include "slipstream/base/setting.h"

namespace slipstream::app {

/// What the help shows for the value of a flag that names a file or a folder to read.
inline constexpr const char* file_type = "FILE";
/// The same of a file to write.
inline constexpr const char* output_type = "OUTPUT";
/// The same of a scanner file to write, which may be the one that is read and added to.
inline constexpr const char* scanner_output_type = "SCANNER";

/// Why the text is no number that a flag takes; empty where it is one. Nothing wants NaN.
std::string why_no_number(const std::string& text, bool is_unsigned, bool is_whole);

/// Throws Error where an output of the command is an input of it, or two outputs are one file.
void require_distinct_files(const CLI::App& command);

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
      constexpr bool has_default =
          std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string>;
      CLI::Option* const option = checked<Value>(app.add_option(flag, value, help));
      return has_default ? option->capture_default_str() : option;
    }
  }

  /// The same of a value that `read` takes, a text where it does not say: what it throws is told.
  template <class Value = std::string>
  CLI::Option* add_read(const std::string& flag,
                        std::type_identity_t<std::function<void(const Value&)>> read,
                        const std::string& help) const {
    return checked<Value>(app.add_option_function<Value>(flag, std::move(read), help));
  }

  /// The same of a value with a name, which `named` finds; the help shows that of the default.
  template <class Value>
  CLI::Option* add_named(const std::string& flag, Value& value,
                         Value (*named)(std::string_view name), std::string_view usual,
                         const std::string& help) const {
    const auto read = [&value, named](const std::string& text) { value = named(text); };
    return add_read<>(flag, read, help)->default_str(std::string(usual));
  }

  /// A switch that sets a bool to false.
  CLI::Option* add_clearing(const std::string& flag, bool& value, const std::string& help) const {
    return app
        .add_flag_callback(
            flag, [&value] { value = false; }, help)
        ->group(name);
  }

  /// Adds the described settings of a struct that have a flag and a number or a switch; values out
  /// of range throw Error. `add_other(setting, value)` adds the others.
  template <class Settings, class AddOther>
  void add_settings(Settings& settings, const AddOther& add_other) const {
    Settings::for_each_setting(settings, [&](const Setting& setting, auto& value) {
      using Value = std::remove_cvref_t<decltype(value)>;
      if (*setting.flag == '\0') return;
      if constexpr (std::is_same_v<Value, bool>) {
        setting.flag_clears ? add_clearing(setting.flag, value, setting.help)
                            : add(setting.flag, value, setting.help);
      } else if constexpr (std::is_arithmetic_v<typename NumberOf<Value>::Type>) {
        add(setting.flag, value, setting.help)->check([setting](const std::string& text) {
          require_in_range(setting, std::strtod(text.c_str(), nullptr));
          return std::string();
        });
      } else {
        add_other(setting, value);
      }
    });
  }

  /// The same of a file or a folder to read: in a rig file its path is relative to that.
  template <class Value>
  CLI::Option* add_file(const std::string& flag, Value& value, const std::string& help) const {
    if constexpr (std::is_same_v<Value, std::optional<std::filesystem::path>>) {
      return add_read<>(
                 flag, [&value](const std::string& path) { value = path; }, help)
          ->type_name(file_type);
    } else {
      return add(flag, value, help)->type_name(file_type);
    }
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

 private:
  /// In this group; a number is checked before it is read.
  template <class Value>
  CLI::Option* checked(CLI::Option* option) const {
    using Number = typename NumberOf<Value>::Type;
    if constexpr (std::is_arithmetic_v<Number>) {
      option->check([option](const std::string& text) {
        const bool left_out = option->get_expected_min() == 0 && text.empty();
        return left_out
                   ? ""
                   : why_no_number(text, std::is_unsigned_v<Number>, std::is_integral_v<Number>);
      });
    }
    return option->group(name);
  }
};

}  // namespace slipstream::app
