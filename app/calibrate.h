#pragma once

#include <CLI/App.hpp>

#include "app/commands.h"

namespace slipstream::app {

/// Each adds a subcommand to `slipstream calibrate`.
void add_calibrate_board(CLI::App& calibrate, Command& chosen);
void add_calibrate_geometry(CLI::App& calibrate, Command& chosen);
void add_calibrate_verify(CLI::App& calibrate, Command& chosen);
void add_calibrate_ambient(CLI::App& calibrate, Command& chosen);
void add_calibrate_gamma(CLI::App& calibrate, Command& chosen);
void add_calibrate_noise(CLI::App& calibrate, Command& chosen);

}  // namespace slipstream::app
