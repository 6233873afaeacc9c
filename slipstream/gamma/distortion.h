#pragma once

#include "slipstream/gamma/harmonics.h"
#include "slipstream/gamma/measured_harmonics.h"
#include "slipstream/gamma/response.h"

namespace slipstream {

/// What N frames of a response measure at true phase phi (rad) for alpha alpha_p = 1, all harmonics
/// included.
MeasuredHarmonics measured_harmonics(const Response& response, int steps, double phi);

/// The phase that N steps measure, Eq. (4.42), all harmonics included: within a third of a turn
/// of phi, not wrapped. phi in rad.
double distorted_phase(const Response& response, int steps, double phi);

/// The same from the harmonics given alone, H_s (4.43) and H_c (4.44) cut off there.
double distorted_phase(const HarmonicRatios& G, int steps, double phi);

/// Delta phi = phi - distorted phase, Eq. (4.45), rad.
double phase_error(const Response& response, int steps, double phi);
double phase_error(const HarmonicRatios& G, int steps, double phi);

/// RMS of the phase error over the circle, rad.
double rms_phase_error(const Response& response, int steps);

}  // namespace slipstream
