#pragma once

#include <CLI/App.hpp>

namespace slipstream::app {

/// Adds --rig to a subcommand: what its file says of settings that the subcommand has, by their
/// flags' names, stands where the command line does not. Settings that only other subcommands of
/// `program` have are passed over; parsing throws Error for one that none has. Of a flag that names
/// a file the path is relative to the rig file.
void add_rig_flag(CLI::App& subcommand, const CLI::App& program);

}  // namespace slipstream::app
