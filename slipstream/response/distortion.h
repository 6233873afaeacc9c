#pragma once

#include <vector>

#include "slipstream/codes/response.h"
#include "slipstream/response/measured_harmonics.h"

namespace slipstream {

/// B_k of Liu 2010, Eq. (4.9), for alpha alpha_p = 1: twice the mean of ((1 + cos theta) / 2)^gamma
/// cos(k theta). From B_0 = 2 Gamma(2 gamma + 1) / (4^gamma Gamma(gamma + 1)^2) by the ratio
/// (4.14). k >= 0; gamma > 0.
double harmonic(double gamma, int k);

/// G_m = B_m / B_1 of a power law, Eq. (4.40): [0] is G_0 (4.59), [1] is 1.
using HarmonicRatios = std::vector<double>;

/// G_0 ... G_highest by the recurrence (4.40). highest >= 1; gamma > 0.
HarmonicRatios harmonic_ratios(double gamma, int highest);

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
