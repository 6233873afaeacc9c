#pragma once

#include <vector>

#include "response/correction.h"
#include "slipstream/frame_set.h"
#include "slipstream/image.h"
#include "slipstream/response.h"

// Formulas of the dissertation, on noise and gamma, that slipstream does not need.
namespace slipstream {

/// Variance of X and Y, and so of the reflectivity (3.36), under noise of variance sigma_w^2 (grey
/// levels^2): Eq. (3.27); with c_1 or c_2 as `share`, (3.95) and (3.96).
double reflectivity_variance(int steps, double alpha_p, double noise_variance, double share = 1);

/// Estimate of alpha that is stable for every c_1: Eq. (3.97), c_1 alpha_1 + c_2 alpha_2, from the
/// estimates by either modulation.
double weighted_reflectivity(double alpha_1, double alpha_2, double c1);

/// Variance of this estimate: Eq. (3.98), 16 sigma_w^2 / (N alpha_p^2).
double weighted_reflectivity_variance(int steps, double alpha_p, double noise_variance);

/// Variance of the reference signal in the half phase channel of 4-pattern PCMP, relative to
/// sigma_w^2: Eq. (3.76).
double half_phase_reference_variance(double alpha, double alpha_p, double c1, double R);

/// B_k of Liu 2010, Eq. (4.9), for alpha alpha_p = 1: twice the mean of ((1 + cos theta) / 2)^gamma
/// cos(k theta). From B_0 = 2 Gamma(2 gamma + 1) / (4^gamma Gamma(gamma + 1)^2) by the ratio
/// (4.14). k >= 0; gamma > 0.
double harmonic(double gamma, int k);

/// G_m = B_m / B_1 of a power law, Eq. (4.40): [0] is G_0 (4.59), [1] is 1.
using HarmonicRatios = std::vector<double>;

/// G_0 ... G_highest by the recurrence (4.40). highest >= 1; gamma > 0.
HarmonicRatios harmonic_ratios(double gamma, int highest);

/// distorted_phase from the given harmonics only: H_s (4.43) and H_c (4.44) are truncated.
double distorted_phase(const HarmonicRatios& G, int steps, double phi);

double phase_error(const HarmonicRatios& G, int steps, double phi);

/// True phase for a measured one, from the given harmonics only, as in Table 4.1.
double true_phase(const HarmonicRatios& G, int steps, double measured);

/// RMS of the phase error over the circle, rad.
double rms_phase_error(const Response& response, int steps);

/// Double three-step phase shifting, a common alternative to phase correction: six frames of one
/// sinusoid are two sets of three, a sixth of a turn apart, whose phases are averaged. The error of
/// Eq. (4.45) for N = 3 changes its sign with a sixth of a turn, so its largest part cancels; this
/// costs three frames. Wrapped phase of every pixel, rad, [0, 2 pi), from the 6 frames that start
/// at `first`.
Image<double> double_three_step_phase(const FrameViews& frames, int first);

}  // namespace slipstream
