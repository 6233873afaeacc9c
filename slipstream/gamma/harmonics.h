#pragma once

#include <vector>

#include "slipstream/gamma/response.h"

namespace slipstream {

/// B_k of Liu 2010, Eq. (4.9), for alpha alpha_p = 1: twice the mean of ((1 + cos theta) / 2)^gamma
/// cos(k theta). From B_0 = 2 Gamma(2 gamma + 1) / (4^gamma Gamma(gamma + 1)^2) by the ratio
/// (4.14). k >= 0; gamma > 0.
double harmonic(double gamma, int k);

/// G_m = B_m / B_1 of a response, Eq. (4.40): [0] is G_0 (4.59), [1] is 1.
using HarmonicRatios = std::vector<double>;

/// G_0 ... G_highest of a power law by the recurrence (4.40). highest >= 1; gamma > 0.
HarmonicRatios harmonic_ratios(double gamma, int highest);

/// The same of any response, from `4 highest` or more samples of its Fourier series. Harmonics
/// above are folded in where the response is not smooth.
HarmonicRatios harmonic_ratios(const Response& response, int highest);

/// The least highest harmonic M with which the phase of Eq. (4.42) is within `accuracy` (rad) of
/// that of the infinite series, at any phase. From the tail, which telescopes: sum |G_m| for m > M
/// is (M + 1 + gamma) |G_{M+1}| / (2 gamma) once M + 1 > gamma. N >= 3, gamma > 0, accuracy > 0.
int highest_harmonic(double gamma, int steps, double accuracy);

}  // namespace slipstream
