#include "slipstream/response/distortion.h"

#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>

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

MeasuredHarmonics measured_harmonics(const Response& response, int steps, double phi) {
  MeasuredHarmonics harmonics;
  for (int n = 0; n < steps; ++n) {
    const double I_n = light_at(response, 0.5 + 0.5 * std::cos(phi - 2 * pi * n / steps));  // (4.2)
    const std::complex<double> turn = std::polar(1.0, 2 * pi * n / steps);
    harmonics.mean += I_n / steps;
    harmonics.fundamental += 2.0 / steps * I_n * turn;
    harmonics.second += 2.0 / steps * I_n * turn * turn;
    harmonics.third += 2.0 / steps * I_n * turn * turn * turn;
  }
  return harmonics;
}

double phase_error(const Response& response, int steps, double phi) {
  return -std::arg(measured_harmonics(response, steps, phi).fundamental * std::polar(1.0, -phi));
}

double phase_error(const HarmonicRatios& G, int steps, double phi) {
  const auto ratio = [&](int m) {
    return static_cast<std::size_t>(m) < G.size() ? G[static_cast<std::size_t>(m)] : 0;
  };
  double sine = 0, cosine = 1;
  for (int k = 1; static_cast<std::size_t>(k * steps - 1) < G.size(); ++k) {
    const double below = ratio(k * steps - 1), above = ratio(k * steps + 1);
    sine += (below - above) * std::sin(k * steps * phi);    // (4.38)
    cosine += (below + above) * std::cos(k * steps * phi);  // (4.39)
  }
  return std::atan2(sine, cosine);
}

double distorted_phase(const Response& response, int steps, double phi) {
  return phi - phase_error(response, steps, phi);
}

double distorted_phase(const HarmonicRatios& G, int steps, double phi) {
  return phi - phase_error(G, steps, phi);
}

double rms_phase_error(const Response& response, int steps) {
  constexpr int samples = 2048;  // of one of the N periods
  double sum = 0;
  for (int i = 0; i < samples; ++i) {
    const double error = phase_error(response, steps, 2 * pi * i / (samples * steps));
    sum += error * error;
  }
  return std::sqrt(sum / samples);
}

}  // namespace slipstream
