#include "slipstream/gamma/harmonics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "slipstream/gamma/distortion.h"

namespace slipstream {

using std::numbers::pi;

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

HarmonicRatios harmonic_ratios(const Response& response, int highest) {
  const int samples = std::max(4 * highest, 4096);
  std::vector<double> light(static_cast<std::size_t>(samples));
  for (int i = 0; i < samples; ++i) {
    light[static_cast<std::size_t>(i)] =
        light_at(response, 0.5 + 0.5 * std::cos(2 * pi * i / samples));
  }
  HarmonicRatios B;
  for (int k = 0; k <= highest; ++k) {
    double sum = 0;
    for (int i = 0; i < samples; ++i) {
      const auto turn = static_cast<double>(static_cast<long>(k) * i % samples);
      sum += light[static_cast<std::size_t>(i)] * std::cos(2 * pi * turn / samples);
    }
    B.push_back(2 * sum / samples);
  }
  const double B_1 = B[1];
  for (double& ratio : B) ratio /= B_1;
  return B;
}

int highest_harmonic(double gamma, int steps, double accuracy) {
  // The error of an angle is at most the error of the vector over the vector's length, and that is
  // least in the middle between two peaks of the modulation.
  const double shortest = measured_harmonics(PowerLaw{gamma}, steps, pi / steps).B_1();
  const double B_1 = harmonic(gamma, 1);
  double G = 1;
  for (int M = 1;; ++M) {
    G *= (gamma - M) / (gamma + M + 1);  // G_{M+1}
    if (G == 0) return M;
    if (M + 1 <= gamma) continue;
    // Of N consecutive terms, which fall, two are kept: (4.43), (4.44).
    const double tail = (M + 1 + gamma) * std::abs(G) / (2 * gamma);
    const double kept = std::min(tail, 2 * tail / steps + 2 * std::abs(G));
    if (kept * B_1 <= accuracy * shortest) return M;
  }
}

}  // namespace slipstream
