#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Each adds a kind of calibration to the group `calibrate`.
void add_calibrate_ambient(CLI::App& calibrate, SharedFlags& shared, Command& chosen);
void add_calibrate_gamma(CLI::App& calibrate, SharedFlags& shared, Command& chosen);
void add_calibrate_noise(CLI::App& calibrate, SharedFlags& shared, Command& chosen);

}  // namespace slipstream::app
