#pragma once

#include "app/commands.h"

namespace slipstream::app {

/// Adds `calibrate ambient`, which measures ambient light.
void add_calibrate_ambient(const Commands& calibrate);

/// Adds `calibrate colour`, which measures colour crosstalk.
void add_calibrate_colour(const Commands& calibrate);

/// Adds `calibrate gamma`, which measures the response of the projector.
void add_calibrate_gamma(const Commands& calibrate);

/// Adds `calibrate noise`, which measures the noise variance of the frames.
void add_calibrate_noise(const Commands& calibrate);

}  // namespace slipstream::app
