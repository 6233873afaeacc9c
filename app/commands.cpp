#include "app/commands.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <tuple>

#include <unistd.h>

#include "app/rig_rights.h"
#include "base/numbers.h"
#include "io/file.h"
#include "io/result_files.h"
#include "slipstream/scanner_file.h"

namespace slipstream::app {
namespace {

/// Outputs and verbosity of a run do not belong to the rig.
void collect_settings(const CLI::App& app, std::set<std::string>& names) {
  static const std::set<std::string> of_run{"rig", "public", "help", "version", "output", "json"};

  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      if (!of_run.contains(name)) names.insert(name);
    }
  }
  for (const CLI::App* const sub : app.get_subcommands(nullptr)) collect_settings(*sub, names);
}

/// Whether the option's value names a file or a folder to write.
bool is_output(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return type == output_type || type == output_folder_type || type == scanner_output_type;
}

/// Paths in a rig file, also after replay:, are relative to the file.
std::string resolved(const CLI::Option& option, const std::string& value, const fs::path& folder) {
  const std::string replay = "replay:";
  if (option.check_lname("scanner")) return scanner_in(folder, value).string();
  if (option.get_type_name() == file_type) return (folder / value).string();
  if (option.check_lname("source") && value.starts_with(replay)) {
    return replay + (folder / value.substr(replay.size())).string();
  }
  return value;
}

bool apply(const RigSetting& setting, const fs::path& folder, const RigRights& rights,
           CLI::Option& option) {
  const auto given = [](const CLI::Option* other) { return other->count() > 0; };

  // The command line wins: it may give the setting itself or one that excludes it. A setting whose
  // partner is absent, such as --resume without --manifest, does not apply either.
  if (given(&option) || std::ranges::any_of(option.get_excludes(), given) ||
      !std::ranges::all_of(option.get_needs(), given)) {
    return false;
  }

  const bool is_switch = option.get_expected_max() == 0;  // its name may start with no-
  for (const std::string& value : setting.values) {
    option.add_result(is_switch ? option.get_flag_value(setting.name, value)
                                : resolved(option, value, folder));
  }

  // The option has taken a value such as "[web:8080,web:8081]" apart.
  for (const std::string& value : option.results()) require_rig_may(option, value, rights);

  option.run_callback();
  return true;
}

/// Whether it is `serve`, not `camera serve`.
bool is_service(const CLI::App& subcommand, const CLI::App& program) {
  return subcommand.get_name() == "serve" && subcommand.get_parent() == &program;
}

void apply(const fs::path& file, CLI::App& subcommand, const CLI::App& program, AppliedRig& rig) {
  rig.file = file.string();
  rig.settings.clear();

  // 1. The settings of all commands, as one rig file may serve several.
  std::set<std::string> known, named;
  std::set<const CLI::Option*> applied;
  collect_settings(program, known);

  // 2. Each setting of the file that this command has.
  const CLI::Option* const is_public = subcommand.get_option_no_throw("--public");
  const RigRights rights{.replaces_files = !is_service(subcommand, program),
                         .lets_others_in = is_public != nullptr && is_public->count() > 0};

  for (const RigSetting& setting : read_rig(file)) {
    const auto refuse = [&](const std::string& why) {
      throw Error(fmt::format("{}: line {}: {}", file.string(), setting.line, why));
    };
    if (!known.contains(setting.name)) {
      refuse(fmt::format("no command has a setting '{}'{}", setting.name,
                         did_you_mean(setting.name, known)));
    }
    if (!named.insert(present_name(setting.name)).second) {
      refuse(fmt::format("'{}' is named twice, by a former name too; leave out one",
                         present_name(setting.name)));
    }

    CLI::Option* const option = subcommand.get_option_no_throw("--" + setting.name);
    if (option == nullptr) continue;

    // `mesh` is the object of the virtual scanner, not a mesh to write.
    if (setting.name == "mesh" && is_output(*option)) continue;

    for (const CLI::Option* const other : option->get_excludes()) {
      if (applied.contains(other)) {
        refuse(fmt::format("'{}' and '{}' exclude each other; leave out one",
                           other->get_single_name(), setting.name));
      }
    }

    try {
      if (apply(setting, file.parent_path(), rights, *option)) {
        rig.settings.push_back(setting);
        applied.insert(option);
      }
    } catch (const CLI::ConversionError&) {  // a switch; numbers were checked before
      refuse(fmt::format("{} '{}': expected true or false", setting.name, setting.values.front()));
    } catch (const CLI::ParseError& error) {
      refuse(error.what());
    } catch (const Error& error) {
      refuse(error.what());
    }
  }

  // In the order of the flags, as on the command line: --raw precedes the filters it keeps.
  for (CLI::Option* const option : subcommand.get_options()) {
    const bool is_rig = option->check_name("--rig") || option->check_name("rig");
    if (option->count() > 0 && !is_rig) option->run_callback();
  }
}

/// Whether `text` contains `word` as a whole word.
bool has_word(const std::string& text, const std::string& word) {
  const auto inside = [&](std::size_t at) {
    return at < text.size() && std::isalnum(static_cast<unsigned char>(text[at])) != 0;
  };

  for (std::size_t at = text.find(word); at != text.npos; at = text.find(word, at + 1)) {
    if (!inside(at - 1) && !inside(at + word.size())) return true;
  }
  return false;
}

/// How clearly the message names the setting: by flag, name or value.
int clarity(const RigSetting& setting, const std::string& message) {
  // "minimum modulation" is minimum-modulation.
  const std::string last = setting.name.substr(setting.name.rfind('-') + 1);

  const bool names_flag = has_word(message, "--" + present_name(setting.name)) ||
                          message.find("'" + setting.name + "'") != message.npos;
  const bool names_setting = has_word(message, last.size() > 5 ? last : setting.name);
  const bool names_value = std::ranges::any_of(setting.values, [&](const std::string& value) {
    const std::string what = value.substr(value.find(':') + 1);  // of "replay:PATH"
    return what.size() > 1 && has_word(message, what);
  });

  return (names_flag ? 4 : 0) + (names_setting ? 2 : 0) + (names_value ? 1 : 0);
}

/// A folder's path, the same however it is written.
fs::path plain_folder(const fs::path& folder) {
  return (fs::absolute(folder) / "").lexically_normal();
}

/// Refuses a file that cannot be written to its folder. `made`: folders that the command makes.
void require_writable(const std::string& path, const fs::path& target,
                      const std::set<fs::path>& made) {
  const fs::path parent = target.parent_path();
  const fs::path folder = parent.empty() ? fs::path(".") : parent;

  // The name of a folder may be known only with the scan.
  if (folder.string().find('{') != std::string::npos) return;

  if (::access(folder.c_str(), W_OK) == 0) return;
  const int error = errno;
  if (error == ENOENT && made.contains(plain_folder(folder))) return;
  throw WorldError(fmt::format("cannot write {}: {}", path, std::strerror(error)));
}

}  // namespace

std::string why_no_number(const std::string& text, bool is_unsigned, bool is_whole) {
  if (text.empty()) return "a number is missing";
  if (is_unsigned && text.find('-') != std::string::npos) return text + " is below 0";

  // The whole text must be a finite number; strtod alone would accept a number at its start.
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  if (*end != '\0') return "'" + text + "' is not a number";
  if (!std::isfinite(number)) return text + " is not finite";

  return is_whole && number != std::floor(number) ? text + " is not a whole number" : "";
}

std::string written_by(const CLI::Option& option, const std::string& value) {
  constexpr std::string_view mcap = "mcap:";
  if (option.check_lname("publish") && value.starts_with(mcap)) return value.substr(mcap.size());
  return is_output(option) ? value : "";
}

void require_distinct_files(const CLI::App& command) {
  constexpr std::string_view replay = "replay:";
  DistinctFiles files;
  std::set<fs::path> made;  // folders

  const auto for_each_value = [&](const auto& take) {
    for (const CLI::Option* const option : command.get_options()) {
      for (const std::string& value : option->results()) take(*option, value);
    }
  };

  // Inputs first, whatever the order of the flags: each output is compared with them.
  for_each_value([&](const CLI::Option& option, const std::string& value) {
    if (option.check_name("--scanner")) {
      files.add_scanner(value);
    } else if (option.get_type_name() == file_type) {
      files.add_input(value);
    }
    if (value.starts_with(replay)) files.add_input(value.substr(replay.size()));
    if (option.get_type_name() == output_folder_type && !value.empty()) {
      made.insert(plain_folder(value));
    }
  });

  for_each_value([&](const CLI::Option& option, const std::string& value) {
    const std::string path = written_by(option, value), type = option.get_type_name();
    if (path.empty()) return;

    // The help of a flag says whether it writes to standard output.
    const bool may_print = option.get_description().find("standard output") != std::string::npos;
    throw_if(path == standard_output && !may_print,
             "{} -: cannot be written to standard output; name a file", option.get_name());

    if (type == output_folder_type && lower_case_extension(path) != ".slip") {
      files.add_output_folder(path);
      return;
    }

    // Devices, pipes and folders are refused before any work, and so are files in a folder that
    // takes none. Names without an ending are folders of convert's scans, which it makes with their
    // parents. The outputs of a plan are written later, maybe on other machines.
    std::error_code unknown;
    const bool has_ending = !lower_case_extension(path).empty();
    const bool is_of_plan = command.get_option_no_throw("--plan") != nullptr;
    if (path != standard_output && (has_ending || !fs::is_directory(path, unknown))) {
      const fs::path target = output_target(path);
      if (has_ending && !is_of_plan) require_writable(path, target, made);
    }
    type == scanner_output_type ? files.add_scanner_output(path) : files.add_output(path);
  });
}

void tell_replaced(const fs::path& folder, Output& output) {
  if (fs::exists(folder / "scan.yaml")) output.say("{}: replacing its scan", folder.string());
}

Size size_from(const std::string& text, const std::string& flag) {
  const std::optional<Size> size = size_of_text(text);
  throw_if(!size.has_value(),
           "{} '{}' is not a size; give width x height in pixels, e.g. 1824x1140", flag, text);
  throw_if(std::uint64_t{1} * size->width * size->height > largest_picture,
           "{} {}: at most {} pixels", flag, text, largest_picture);
  return *size;
}

Rectangle region_from(const std::string& text, const std::string& flag) {
  const std::optional<Rectangle> region = rectangle_of_text(text);
  throw_if(!region.has_value(),
           "{} '{}' is not a region; give width x height + x + y, e.g. 640x480+16+8", flag, text);
  return *region;
}

Eigen::Vector3d place_from(const std::string& text, const std::string& flag) {
  const std::vector<double> numbers = numbers_in<double>(text, ',');
  throw_if(numbers.size() != 3, "{} '{}': expected x,y,z in mm, e.g. 100,0,0", flag, text);
  return {numbers[0], numbers[1], numbers[2]};
}

void add_rig_flag(CLI::App& subcommand, const CLI::App& program, AppliedRig& rig) {
  if (opens_ports(subcommand)) {
    const std::string help = "let other machines reach the ports that the rig file opens";
    subcommand.add_flag("--public", help);
  }

  const bool served = is_service(subcommand, program);
  subcommand
      .add_option_function<std::string>(
          served ? "rig" : "--rig",
          [&](const std::string& file) { apply(file, subcommand, program, rig); },
          "file of settings named like the flags; the command line overrides it: .yaml")
      ->type_name(file_type)
      ->required(served);
}

std::string located(const AppliedRig& rig, const std::string& text) {
  const std::string message = with_flags(text);
  if (message.starts_with(rig.file + ": line ")) return message;

  // The setting that the message names most clearly; of several, the first in the file.
  int clearest = 0, line = 0;
  for (const RigSetting& setting : rig.settings) {
    const int clear = clarity(setting, message);
    if (clear > clearest) std::tie(clearest, line) = std::pair(clear, setting.line);
  }

  return clearest == 0 ? message : fmt::format("{}: line {}: {}", rig.file, line, message);
}

}  // namespace slipstream::app
