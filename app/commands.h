#pragma once

#include <functional>
#include <memory>

#include <CLI/App.hpp>

#include "app/output.h"

namespace slipstream::app {

/// A subcommand that has been chosen and its flags read: does the work, tells `Output` about it.
using Command = std::function<void(Output&)>;

/// Flags that every subcommand has.
struct SharedFlags {
  bool json = false;
  int threads = 0;  ///< 0: as many as the machine has cores
};

void add_shared_flags(CLI::App& subcommand, SharedFlags& shared);

/// Each adds a subcommand to the program; when it is chosen, `chosen` becomes its work.
void add_patterns(CLI::App& program, SharedFlags& shared, Command& chosen);
void add_simulate(CLI::App& program, SharedFlags& shared, Command& chosen);
void add_calibrate(CLI::App& program, SharedFlags& shared, Command& chosen);
void add_design(CLI::App& program, SharedFlags& shared, Command& chosen);
void add_reconstruct(CLI::App& program, SharedFlags& shared, Command& chosen);
void add_project(CLI::App& program, SharedFlags& shared, Command& chosen);  // with SLIPSTREAM_VIEW
void add_live(CLI::App& program, SharedFlags& shared, Command& chosen);
void add_view(CLI::App& program, SharedFlags& shared, Command& chosen);  // with SLIPSTREAM_VIEW
void add_reproduce(CLI::App& program, SharedFlags& shared, Command& chosen);
void add_bench(CLI::App& program, SharedFlags& shared, Command& chosen);
void add_record(CLI::App& program, SharedFlags& shared, Command& chosen);
void add_camera(CLI::App& program, SharedFlags& shared, Command& chosen);

}  // namespace slipstream::app
