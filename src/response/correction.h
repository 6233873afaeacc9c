#pragma once

#include <functional>
#include <optional>

#include "decode/phase_decoder.h"
#include "slipstream/pattern_set.h"
#include "slipstream/response.h"

namespace slipstream {

/// The phase that N steps measure, Eq. (4.42), all harmonics included: within a third of a turn of
/// phi, not wrapped. phi in rad.
double distorted_phase(const Response& response, int steps, double phi);

/// Delta phi = phi - distorted phase, Eq. (4.45), rad.
double phase_error(const Response& response, int steps, double phi);

/// The true phase for a measured one, Liu 2010, Eqs. (4.56), (4.57): solves the distorted phase
/// (4.42) for phi to rounding. `measured` in rad, any; N >= 3.
double true_phase(const Response& response, int steps, double measured);

/// The same for any increasing `distorted(phi)` that equals phi at multiples of pi / N.
double true_phase(const std::function<double(double)>& distorted, int steps, double measured);

/// Factor by which correction multiplies the noise of a measured phase, at true phase phi, rad:
/// above 1 where the response compresses phases. N >= 3.
double noise_gain(const Response& response, int steps, double phi);

/// The correction of the measured phase, as a table: made once per device. Its length is the power
/// of two, 256 to 65536, at which linear interpolation is within `accuracy` (rad); above gamma 4.5,
/// N = 3 would need more where the measured phase hardly changes, and is less accurate there.
/// Throws Error if N < 3 or gamma is out of range.
PhaseCorrection phase_correction(const Response& response, int steps, double accuracy = 2e-7);

/// The same for the frames of one sinusoid at any angles, which the band's least-squares weights
/// imply, for phases around the whole circle: `steps` is 1. nullopt for other bands, and if the
/// measured phase does not rise with the true one.
std::optional<PhaseCorrection> phase_correction(const Response& response, const Band& band);

/// One correction per distinct step count, and one for the bands without a run of steps, as 1 step,
/// if they share one.
PhaseCorrections phase_corrections(const Response& response, const Layout& layout,
                                   double accuracy = 2e-7);

/// The images that a projector with that response turns into the light of `patterns`: the inverse
/// response is applied before projection. The alternative to correcting the phase; it costs grey
/// levels, because images are rounded to the projector's levels afterwards.
PatternSet precompensated(const PatternSet& patterns, const Response& response);

}  // namespace slipstream
