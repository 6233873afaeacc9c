#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/commands.h"

namespace slipstream::app {

/// Views of an object that turns between scans.
struct TurntableFlags {
  std::optional<int> views;
  std::optional<double> step;  ///< degrees; default: a full turn over the views
  std::string command;         ///< run between scans; empty: a person turns and presses Enter
};

/// Adds --turntable and --turn-step.
void add_turntable_flags(const FlagGroup& group, TurntableFlags& flags);

/// Degrees from view to view. Throws Error if views or step are out of range.
double turn_step(const TurntableFlags& flags);

/// The folder of view `number`, from 1: "FOLDER/view01". Names have as many digits as the last view
/// needs, at least two, so that they sort in the views' order.
std::string folder_of_view(const TurntableFlags& flags, const std::filesystem::path& folder,
                           int number);

/// Lets the object be turned for view `number`: runs the command, in which {step} and {view} stand
/// for degrees and number, or waits for Enter. The command prints to stderr, as stdout may carry
/// JSON. Throws WorldError if the command fails or standard input ends.
void turn_table(const TurntableFlags& flags, int number, Output& output);

/// Prints where the views are, and how to join them.
void tell_views(const TurntableFlags& flags, const std::filesystem::path& folder, Output& output);

}  // namespace slipstream::app
