#pragma once

namespace slipstream {

/// Variance of the wrapped phase (rad^2) of N-step PMP under additive noise of variance sigma_w^2
/// (grey levels^2) on every frame, at reflectivity alpha under patterns of amplitude alpha_p: Liu
/// 2010, Eq. (3.38), 8 sigma_w^2 / (N alpha^2 alpha_p^2). Holds for small noise; alpha, alpha_p >
/// 0.
double phase_variance(int steps, double alpha, double alpha_p, double noise_variance);

/// Variance of the projector coordinate y (fields^2) for f periods across the field: Eq. (3.40),
/// the phase variance divided by (2 pi f)^2.
double coordinate_variance(double phase_variance, double frequency);

/// Variance that rounding to whole grey levels adds to each frame: 1/12.
inline constexpr double quantisation_variance = 1.0 / 12;

}  // namespace slipstream
