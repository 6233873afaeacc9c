#pragma once

#include <string>

#include <CLI/App.hpp>

namespace slipstream::app {

/// Rights of a rig file, which may come from anywhere.
struct RigRights {
  bool replaces_files = true;   ///< of the format that it writes; `serve` chooses new names
  bool lets_others_in = false;  ///< --public: may open ports to other machines
};

/// Throws Error unless a rig file may give this value to the option. Its outputs must lie in the
/// working folder or below, have an ending of their format, and replace only files of that format.
/// Its ports are for this machine only, and it may not run commands (--turn-command).
void require_rig_may(const CLI::Option& option, const std::string& value, const RigRights& rights);

/// Whether the subcommand has options that open ports.
bool opens_ports(const CLI::App& subcommand);

}  // namespace slipstream::app
