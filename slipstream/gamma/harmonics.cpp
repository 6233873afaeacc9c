#include "slipstream/gamma/harmonics.h"

#include <cmath>

namespace slipstream {

double harmonic(double gamma, int k) {
  double B =
      2 * std::exp(std::lgamma(2 * gamma + 1) - 2 * std::lgamma(gamma + 1) - gamma * std::log(4.0));
  for (int n = 0; n < k; ++n) B *= (gamma - n) / (gamma + n + 1);  // (4.14)
  return B;
}

HarmonicRatios harmonic_ratios(double gamma, int highest) {
  HarmonicRatios G{(gamma + 1) / gamma, 1};  // (4.59)
  for (int n = 2; n <= highest; ++n) {
    G.push_back(G.back() * (gamma - n + 1) / (gamma + n));  // (4.40)
  }
  return G;
}

}  // namespace slipstream
