#include "app/rig_flag.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <string>

#include <fmt/format.h>

#include "app/flag_group.h"
#include "slipstream/error/did_you_mean.h"
#include "slipstream/error/error.h"
#include "slipstream/io/rig_file.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

/// What a run writes and how it talks is not of the rig.
bool is_of_rig(const std::string& name) {
  static const std::set<std::string> of_run{"rig", "help", "version", "output", "json"};
  return !of_run.contains(name);
}

void collect_settings(const CLI::App& app, std::set<std::string>& names) {
  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      if (is_of_rig(name)) names.insert(name);
    }
  }
  const auto any = [](const CLI::App*) { return true; };
  for (const CLI::App* const command : app.get_subcommands(any)) collect_settings(*command, names);
}

/// Whether the command line, or what it does without, leaves no room for the option.
bool is_ruled_out(const CLI::Option& option) {
  const auto given = [](const CLI::Option* other) { return other->count() > 0; };
  const auto& excludes = option.get_excludes();
  const auto& needs = option.get_needs();
  return std::any_of(excludes.begin(), excludes.end(), given) ||
         !std::all_of(needs.begin(), needs.end(), given);
}

/// A path in the rig file is relative to that; so is the one behind replay:.
std::string resolved(const CLI::Option& option, const std::string& value, const fs::path& folder) {
  const std::string replay = "replay:";
  if (option.get_type_name() == file_type) return (folder / value).string();
  if (option.check_lname("source") && value.starts_with(replay)) {
    return replay + (folder / value.substr(replay.size())).string();
  }
  return value;
}

void apply(const RigSetting& setting, const fs::path& folder, CLI::Option& option) {
  if (option.count() > 0 || is_ruled_out(option)) return;
  for (const std::string& value : setting.values) {
    option.add_result(resolved(option, value, folder));
  }
  option.run_callback();
}

void apply(const fs::path& file, CLI::App& subcommand, const CLI::App& program) {
  std::set<std::string> known;
  collect_settings(program, known);
  for (const RigSetting& setting : read_rig(file)) {
    const auto refuse = [&](const std::string& why) {
      throw Error(fmt::format("{}: line {}: {}", file.string(), setting.line, why));
    };
    if (!known.contains(setting.name)) {
      refuse(fmt::format("no command has a setting '{}'{}", setting.name,
                         did_you_mean(setting.name, known)));
    }
    CLI::Option* const option = subcommand.get_option_no_throw("--" + setting.name);
    if (option == nullptr) continue;
    try {
      apply(setting, file.parent_path(), *option);
    } catch (const CLI::ParseError& error) {
      refuse(error.what());
    }
  }
}

}  // namespace

void add_rig_flag(CLI::App& subcommand, const CLI::App& program) {
  subcommand
      .add_option_function<std::string>(
          "--rig", [&](const std::string& file) { apply(file, subcommand, program); },
          "settings by their flags' names, which the command line goes before: .yaml")
      ->type_name(file_type);
}

}  // namespace slipstream::app
