#pragma once

#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "slipstream/io/rig_file.h"

namespace slipstream::app {

/// What a rig file said that the command line did not.
struct RigSaid {
  std::vector<std::string> arguments{};  ///< of the command line, the last first
  std::string file{};                    ///< empty where there is none
  std::vector<RigSetting> settings{};
};

/// Adds --rig to a subcommand, to serve as the argument that it must have: what its file says of
/// settings that the subcommand has, by their flags' names, stands where the command line does not,
/// and in `said`. Settings that only other subcommands of `program` have are passed over; parsing
/// throws Error for one that none has. Of a flag that names a file the path is relative to the rig
/// file.
void add_rig_flag(CLI::App& subcommand, const CLI::App& program, RigSaid& said);

/// The message with the line of the setting in front that it names most clearly: "rig.yaml: line 3:
/// ..."; as it was if it names none. What the flags themselves refuse has its line already.
std::string located(const RigSaid& said, const std::string& message);

}  // namespace slipstream::app
