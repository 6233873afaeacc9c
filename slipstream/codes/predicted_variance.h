#pragma once

#include "slipstream/codes/layout.h"
#include "slipstream/codes/pattern_set.h"

namespace slipstream {

// Predicted variances of what is computed from frames with additive noise of variance sigma_w^2
// (grey levels^2): Liu 2010, Chapter 3. All hold for small noise; alpha, alpha_p, c_1, c_2 > 0.

/// Variance that rounding to whole grey levels adds to each frame: 1/12.
inline constexpr double quantisation_variance = 1.0 / 12;

/// Of the wrapped phase, rad^2, of N-step PMP: Eq. (3.38), 8 sigma_w^2 / (N alpha^2 alpha_p^2).
double phase_variance(int steps, double alpha, double alpha_p, double noise_variance);

/// Of y, fields^2, at f periods across the field: Eq. (3.40), the phase variance over (2 pi f)^2.
double coordinate_variance(double phase_variance, double frequency);

/// Of C and of S of a band, on average; for N steps 2 / N sigma_w^2, as in Eqs. (3.36), (3.95).
double component_variance(const Band& band, double noise_variance);

/// Of a cue's number likewise: sigma_w^2 / N in the channels of Eqs. (3.65), (3.75).
double cue_variance(const Cue& cue, double noise_variance);

/// Of a band's phase, rad^2, at a modulation of B grey levels: component_variance over B^2; for N
/// steps Eq. (3.38), with a share of the modulation (3.63), (3.101).
double phase_variance(const Band& band, double modulation, double noise_variance);

/// Of y, fields^2, at a modulation of B grey levels in all bands, with the right fringe order: Eqs.
/// (3.40), (3.63), and band_weights. Of a code alone: of a stripe's width.
double coordinate_variance(const Layout& layout, double modulation, double noise_variance);

/// Of the reference signal in the DC channel of 3-pattern PCMP, over sigma_w^2: Eq. (3.67).
double dc_reference_variance(double alpha, const PatternLight& light, double ambient, double c1,
                             double R);

}  // namespace slipstream
