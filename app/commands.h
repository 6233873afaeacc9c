#pragma once

#include <functional>
#include <memory>
#include <string>

#include <CLI/App.hpp>

#include "app/flag_group.h"
#include "app/output.h"
#include "app/rig_flag.h"

namespace slipstream::app {

/// The chosen subcommand and its parsed flags.
struct Command {
  std::function<void(Output&)> work{};  ///< runs it and reports to `Output`
  RigSaid rig{};
};

/// A subcommand that was added: its flags without a heading of their own, and where values go.
template <class Flags>
struct AddedCommand {
  FlagGroup command;
  Flags& flags;  ///< live as long as the subcommand
};

/// Adds a subcommand to `parent`; when it is chosen, `chosen` calls `work` with its flags.
template <class Flags>
AddedCommand<Flags> add_command(CLI::App& parent, Command& chosen,
                                void (*work)(const Flags&, Output&), const std::string& name,
                                const std::string& help) {
  CLI::App* const command = parent.add_subcommand(name, help);
  const auto flags = std::make_shared<Flags>();
  command->callback([flags, work, &chosen] {
    chosen.work = [flags, work](Output& output) { work(*flags, output); };
  });
  return {{*command}, *flags};
}

/// Each adds a subcommand to the program; when it is chosen, `chosen` has its work.
void add_demo(CLI::App& program, Command& chosen);
void add_patterns(CLI::App& program, Command& chosen);
void add_simulate(CLI::App& program, Command& chosen);
void add_calibrate(CLI::App& program, Command& chosen);
void add_design(CLI::App& program, Command& chosen);
void add_reconstruct(CLI::App& program, Command& chosen);
void add_batch(CLI::App& program, Command& chosen);
void add_assist(CLI::App& program, Command& chosen);
void add_check(CLI::App& program, Command& chosen);
void add_convert(CLI::App& program, Command& chosen);
void add_unwrap(CLI::App& program, Command& chosen);
void add_height(CLI::App& program, Command& chosen);
void add_measure(CLI::App& program, Command& chosen);
void add_compare(CLI::App& program, Command& chosen);
void add_verify(CLI::App& program, Command& chosen);
void add_project(CLI::App& program, Command& chosen);  // with SLIPSTREAM_VIEW
void add_live(CLI::App& program, Command& chosen);
void add_serve(CLI::App& program, Command& chosen);
void add_view(CLI::App& program, Command& chosen);  // with SLIPSTREAM_VIEW
void add_reproduce(CLI::App& program, Command& chosen);
void add_bench(CLI::App& program, Command& chosen);
void add_gpu(CLI::App& program, Command& chosen);
void add_record(CLI::App& program, Command& chosen);
void add_capture(CLI::App& program, Command& chosen);
void add_camera(CLI::App& program, Command& chosen);

/// Each adds a subcommand to `slipstream camera` or `slipstream calibrate`.
void add_camera_serve(CLI::App& camera, Command& chosen);  // with SLIPSTREAM_CAMERAS
void add_calibrate_board(CLI::App& calibrate, Command& chosen);
void add_calibrate_geometry(CLI::App& calibrate, Command& chosen);
void add_calibrate_verify(CLI::App& calibrate, Command& chosen);
void add_calibrate_ambient(CLI::App& calibrate, Command& chosen);
void add_calibrate_colour(CLI::App& calibrate, Command& chosen);
void add_calibrate_gamma(CLI::App& calibrate, Command& chosen);
void add_calibrate_height(CLI::App& calibrate, Command& chosen);
void add_calibrate_noise(CLI::App& calibrate, Command& chosen);

}  // namespace slipstream::app
