#pragma once

#include "slipstream/layout.h"
#include "slipstream/pattern_set.h"

namespace slipstream {

// Predicted variances for frames with additive noise of variance sigma_w^2 (grey levels^2): Liu
// 2010, Chapter 3. All are for small noise; alpha, alpha_p, c_1, c_2 > 0.

/// Variance that rounding to whole grey levels adds to each frame: 1/12.
inline constexpr double quantisation_variance = 1.0 / 12;

/// Variance of the phase of N-step PMP, rad^2: Eq. (3.38), 8 sigma_w^2 / (N alpha^2 alpha_p^2).
double phase_variance(int steps, double alpha, double alpha_p, double noise_variance);

/// Variance of y, fields^2, at f periods across the field: Eq. (3.40), phase variance / (2 pi f)^2.
double coordinate_variance(double phase_variance, double frequency);

/// Variance of a cue's value: sigma_w^2 / N in the channels of Eqs. (3.65), (3.75).
double cue_variance(const Cue& cue, double noise_variance);

/// Variance of a band's phase, rad^2, at a modulation of B grey levels: component_noise(band)
/// sigma_w^2 / B^2; for N steps Eq. (3.38), with a share of the modulation (3.63), (3.101).
double phase_variance(const Band& band, double modulation, double noise_variance);

/// Variance of y, fields^2, at a modulation of B grey levels in all bands, given the correct fringe
/// order: Eqs. (3.40), (3.63), and band_weights. For a code alone, from the stripe width.
double coordinate_variance(const Layout& layout, double modulation, double noise_variance);

/// For the reference signal in the DC channel of 3-pattern PCMP, over sigma_w^2: Eq. (3.67).
double dc_reference_variance(double alpha, const PatternLight& light, double ambient, double c1,
                             double R);

}  // namespace slipstream
