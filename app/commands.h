#pragma once

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <CLI/App.hpp>

#include "app/flag_names.h"
#include "app/output.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/rig_file.h"
#include "slipstream/error.h"
#include "slipstream/image.h"
#include "slipstream/setting.h"

namespace slipstream::app {
namespace fs = std::filesystem;

/// Value type of flags that name a file or a folder to read.
inline constexpr const char* file_type = "FILE";
/// Value type of flags that name a file to write.
inline constexpr const char* output_type = "OUTPUT";
/// Value type of flags that name a folder to write, or a recording if it ends in .slip.
inline constexpr const char* output_folder_type = "FOLDER";
/// Value type of flags that name a scanner file to write, which may also be the input.
inline constexpr const char* scanner_output_type = "SCANNER";

/// Heading of the options that most people need first; their groups add a number, see
/// FlagGroup::common.
inline constexpr const char* common_options = "Common options";

/// Why the text is not a valid number; empty if it is one. NaN is not.
std::string why_no_number(const std::string& text, bool is_unsigned, bool is_whole);

/// The path that a value of the option writes to; empty for options that write nothing.
std::string written_by(const CLI::Option& option, const std::string& value);

/// Throws Error if an output of the command is also an input, if two outputs are the same file, or
/// for standard_output where the command does not write to it. Throws WorldError if an output is a
/// device, a pipe or a folder, or lies in a folder that takes no files.
void require_distinct_files(const CLI::App& command);

/// Says so if a scan in the folder will be replaced.
void tell_replaced(const fs::path& folder, Output& output);

/// Parses "1824x1140". Throws Error naming the flag for anything else.
Size size_from(const std::string& text, const std::string& flag);

/// Parses "640x480+16+8". Throws Error naming the flag for anything else.
Rectangle region_from(const std::string& text, const std::string& flag);

/// Parses "100,0,0", mm. Throws Error naming the flag for anything else.
Eigen::Vector3d place_from(const std::string& text, const std::string& flag);

/// Element type of a flag's value.
template <class Value>
struct NumberOf {
  using Type = Value;
};

template <class Value>
struct NumberOf<std::optional<Value>> : NumberOf<Value> {};

template <class Value>
struct NumberOf<std::vector<Value>> : NumberOf<Value> {};

/// Flags of a subcommand under one heading of its help.
struct FlagGroup {
  CLI::App& app;
  std::string name = "Options";  ///< heading in the help

  /// Adds a flag that sets `value`: a switch for a bool; otherwise its present number or text is
  /// shown as the default. Sizes are written "1824x1140", regions "640x480+16+8".
  template <class Value>
  CLI::Option* add(const std::string& flag, Value& value, const std::string& help) const {
    // 1. A switch.
    if constexpr (std::is_same_v<Value, bool>) {
      return app.add_flag(flag, value, help)->group(name);
    } else if constexpr (std::is_same_v<Value, std::optional<Rectangle>>) {
      // 2. A region or a size, in one word.
      return add_read<>(
          flag, [&value, flag](const std::string& text) { value = region_from(text, flag); }, help);
    } else if constexpr (std::is_same_v<typename NumberOf<Value>::Type, Size>) {
      const auto read = [&value, flag](const std::string& text) { value = size_from(text, flag); };
      CLI::Option* const option = add_read<>(flag, read, help);
      if constexpr (std::is_same_v<Value, Size>) option->default_str(text_of(value));
      return option;
    } else {
      // 3. A number or text shows its present value as default; an optional or a list does not.
      constexpr bool has_default =
          std::is_arithmetic_v<Value> || std::is_same_v<Value, std::string>;
      CLI::Option* const option =
          checked<Value>(app.add_option(with_former_name(flag), value, help));
      return has_default ? option->capture_default_str() : option;
    }
  }

  /// Adds a flag whose value goes to `read`, which may throw.
  template <class Value = std::string>
  CLI::Option* add_read(const std::string& flag,
                        std::type_identity_t<std::function<void(const Value&)>> read,
                        const std::string& help) const {
    return checked<Value>(
        app.add_option_function<Value>(with_former_name(flag), std::move(read), help));
  }

  /// Adds a flag whose value is chosen by name with `named`; `usual` is the default's name.
  template <class Value>
  CLI::Option* add_named(const std::string& flag, Value& value,
                         Value (*named)(std::string_view name), std::string_view usual,
                         const std::string& help) const {
    const auto read = [&value, named](const std::string& text) { value = named(text); };
    return add_read<>(flag, read, help)->default_str(std::string(usual));
  }

  /// Adds a flag for each described number and switch of a struct that has an option; out of range
  /// values throw Error. Calls `add_other(flag, help, value)` for other settings.
  template <class Settings, class... AddOther>
  void add_settings(Settings& settings, const AddOther&... add_other) const {
    Settings::for_each_setting(settings, [&](const Setting& setting, auto& value) {
      using Value = std::remove_cvref_t<decltype(value)>;
      if (*setting.option == '\0') return;
      const std::string flag = flag_of(setting.option), help = with_flags(setting.help);

      if constexpr (std::is_same_v<Value, bool>) {
        const auto set = [&value, on = !setting.option_clears] { value = on; };
        app.add_flag_callback(flag, set, help)->group(name);
      } else if constexpr (std::is_arithmetic_v<typename NumberOf<Value>::Type>) {
        add(flag, value, help)->check([setting](const std::string& text) {
          require_in_range(setting, std::strtod(text.c_str(), nullptr));
          return std::string();
        });
      } else {
        // Boxes, outlines and the like: the caller knows how to read them.
        (add_other(flag, help, value), ...);
      }
    });
  }

  /// Adds a file or folder to read; in a rig file its path is relative to that file.
  template <class Value>
  CLI::Option* add_file(const std::string& flag, Value& value, const std::string& help) const {
    if constexpr (std::is_same_v<Value, std::optional<fs::path>>) {
      const auto read = [&value](const std::string& path) { value = path; };
      return add_read<>(flag, read, help)->type_name(file_type);
    } else if constexpr (std::is_same_v<Value, std::vector<fs::path>>) {
      // One path each time that the flag is given.
      const auto read = [&value](const std::vector<std::string>& paths) {
        value.assign(paths.begin(), paths.end());
      };
      CLI::Option* const option = add_read<std::vector<std::string>>(flag, read, help);
      return option->type_name(file_type)->allow_extra_args(false);
    } else {
      return add(flag, value, help)->type_name(file_type);
    }
  }

  /// Adds a file to write, distinct from all other files; `type` scanner_output_type for a scanner
  /// file, output_folder_type for a folder.
  template <class Value>
  CLI::Option* add_output(const std::string& flag, Value& value, const std::string& help,
                          const char* type = output_type) const {
    return add(flag, value, help)->type_name(type);
  }

  /// Forbids giving any of the others together with the flag.
  void exclude(const char* flag, std::initializer_list<const char*> others) const {
    for (const char* other : others) app.get_option(flag)->excludes(app.get_option(other));
  }

  /// Lists these flags first in the help, in this order.
  void common(std::initializer_list<const char*> flags) const {
    // The help sorts these groups as text: two digits each keep the order.
    int place = 10;
    for (const char* flag : flags) {
      app.get_option(flag)->group(common_options + std::to_string(place++));
    }
  }

  /// Adds example commands (without "slipstream") and optional text to the help.
  void examples(const std::vector<std::string>& commands, const std::string& words = {}) const {
    app.footer(
        fmt::format("{}:\n  slipstream {}{}{}", commands.size() == 1 ? "Example" : "Examples",
                    fmt::join(commands, "\n  slipstream "), words.empty() ? "" : "\n", words));
  }

 private:
  /// Puts the option in this group and validates numbers before parsing.
  template <class Value>
  CLI::Option* checked(CLI::Option* option) const {
    using Number = typename NumberOf<Value>::Type;
    if constexpr (std::is_arithmetic_v<Number>) {
      // A flag whose value may be left out, like --poses, passes an empty text.
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

inline CLI::Option* required(CLI::Option* option) {
  return option->required()->default_str("");
}

/// Settings from a rig file that the command line does not override.
struct AppliedRig {
  std::string file{};  ///< empty without one
  std::vector<RigSetting> settings{};
};

/// Adds --rig to a subcommand (to `serve`, the file as its argument): settings of the file, named
/// like flags, apply unless the command line sets them, and are stored in `rig`. Settings of other
/// subcommands of `program` are skipped; unknown ones, and those beyond its RigRights, throw Error
/// when parsing. Paths are relative to the rig file. Adds --public if the subcommand opens ports.
void add_rig_flag(CLI::App& subcommand, const CLI::App& program, AppliedRig& rig);

/// The message with_flags, prefixed with "rig.yaml: line 3: " of the setting it names most clearly;
/// without prefix if it names none or already has one.
std::string located(const AppliedRig& rig, const std::string& text);

/// Returns act(); its errors name the line of the rig file that they come from.
template <class Act>
auto locating(const AppliedRig& rig, const Act& act) try {
  return act();
} catch (const Error& error) {
  throw Error(located(rig, error.what()));
} catch (const WorldError& error) {
  throw WorldError(located(rig, error.what()));
}

struct LiveFlags;
struct Command;

/// Reads the same command line and rig file once more, into flags of its own. Throws Error.
using ReadAgain = std::function<std::shared_ptr<const Command>()>;

/// The chosen subcommand and its parsed flags.
struct Command {
  std::function<void(Output&)> work{};  ///< runs the command and prints to `Output`
  AppliedRig rig{};
  const LiveFlags* served = nullptr;  ///< flags of `serve`; they live as long as the subcommand
  ReadAgain read_again{};
};

/// An added subcommand: its ungrouped flags and their values.
template <class Flags>
struct AddedCommand {
  FlagGroup command;
  Flags& flags;  ///< lives as long as the subcommand
};

/// The program, or a subcommand, to which subcommands are added.
struct Commands {
  CLI::App& app;
  Command& chosen;

  /// Adds a subcommand; when called, it makes `chosen` run `work` with its flags.
  template <class Flags>
  AddedCommand<Flags> add(void (*work)(const Flags&, Output&), const std::string& name,
                          const std::string& help) const {
    CLI::App* const command = app.add_subcommand(name, help);
    const auto flags = std::make_shared<Flags>();
    command->callback([flags, work, &chosen = chosen] {
      chosen.work = [flags, work](Output& output) { work(*flags, output); };
    });
    return {{*command}, *flags};
  }

  /// Adds a subcommand that has subcommands.
  [[nodiscard]] Commands add_group(const std::string& name, const std::string& help) const {
    return {*app.add_subcommand(name, help)->require_subcommand(1), chosen};
  }
};

/// Adds one command, or a command with its own commands.
using AddCommand = void(const Commands& program);

// The program's commands, which their help describes.
AddCommand add_assist, add_batch, add_bench, add_calibrate, add_camera, add_capture, add_check,
    add_compare, add_convert, add_demo, add_design, add_frame, add_gpu, add_height, add_live,
    add_measure, add_merge, add_patterns, add_project, add_reconstruct, add_record, add_reproduce,
    add_serve, add_simulate, add_studio, add_unwrap, add_verify, add_view;

// The commands of `calibrate`, and those of `frame` that find a pose in a scan.
AddCommand add_calibrate_ambient, add_calibrate_board, add_calibrate_colour, add_calibrate_gamma,
    add_calibrate_geometry, add_calibrate_hand_eye, add_calibrate_height, add_calibrate_noise,
    add_calibrate_points, add_calibrate_projection, add_calibrate_residual, add_calibrate_stitch,
    add_calibrate_touch, add_calibrate_verify, add_calibrate_virtual_robot, add_found_frames;

}  // namespace slipstream::app
