#pragma once

#include <functional>
#include <span>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/response.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/response/harmonics.h"

namespace slipstream {

/// The true phase behind a measured one, Liu 2010, Eqs. (4.56), (4.57): solves the distorted phase
/// (4.42) for phi to rounding. `measured` in rad, any; N >= 3.
double true_phase(const Response& response, int steps, double measured);

/// The same by any `distorted(phi)` that agrees with phi at the multiples of pi / N and rises.
double true_phase(const std::function<double(double)>& distorted, int steps, double measured);

/// What correcting multiplies the noise of a measured phase by, at true phase phi, rad: more than 1
/// where the response presses phases together. N >= 3.
double noise_gain(const Response& response, int steps, double phi);

/// What is added to the measured phase, as a table: made once for a device. Its length is the
/// power of two, 256 to 65536, at which linear interpolation is within `accuracy` (rad); past gamma
/// 4.5, N = 3 needs more than that where the measured phase hardly moves, and is less accurate
/// there. Throws Error where N < 3 or gamma is out of range.
PhaseCorrection phase_correction(const Response& response, int steps, double accuracy = 2e-7);

/// One for each of the step counts.
PhaseCorrections phase_corrections(const Response& response, std::span<const int> step_counts);

/// The pictures that a projector of that response turns into the light of `patterns`: the inverse
/// response is applied before projection. What people do instead of correcting the phase; it costs
/// grey levels, because the pictures are rounded to the projector's after it.
PatternSet precompensated(const PatternSet& patterns, const Response& response);

}  // namespace slipstream
