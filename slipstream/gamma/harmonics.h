#pragma once

#include <vector>

namespace slipstream {

/// B_k of Liu 2010, Eq. (4.9), for alpha alpha_p = 1: twice the mean of ((1 + cos theta) / 2)^gamma
/// cos(k theta). From B_0 = 2 Gamma(2 gamma + 1) / (4^gamma Gamma(gamma + 1)^2) by the ratio
/// (4.14). k >= 0; gamma > 0.
double harmonic(double gamma, int k);

/// G_m = B_m / B_1 of a power law, Eq. (4.40): [0] is G_0 (4.59), [1] is 1.
using HarmonicRatios = std::vector<double>;

/// G_0 ... G_highest by the recurrence (4.40). highest >= 1; gamma > 0.
HarmonicRatios harmonic_ratios(double gamma, int highest);

}  // namespace slipstream
