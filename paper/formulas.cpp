#include "paper/formulas.h"

#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "base/parallel_rows.h"
#include "decode/equations.h"
#include "response/correction.h"

namespace slipstream {

using std::numbers::pi;

double reflectivity_variance(int steps, double alpha_p, double noise_variance, double share) {
  return 8 * noise_variance / (steps * std::pow(alpha_p * share, 2));
}

double weighted_reflectivity(double alpha_1, double alpha_2, double c1) {
  return c1 * alpha_1 + (1 - c1) * alpha_2;
}

double weighted_reflectivity_variance(int steps, double alpha_p, double noise_variance) {
  return 16 * noise_variance / (steps * std::pow(alpha_p, 2));
}

double half_phase_reference_variance(double alpha, double alpha_p, double c1, double R) {
  return (1 / std::pow(1 - c1, 2) + 2 * std::pow(R / c1, 2)) / std::pow(alpha * alpha_p, 2);
}

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

double distorted_phase(const HarmonicRatios& G, int steps, double phi) {
  return phi - phase_error(G, steps, phi);
}

double true_phase(const HarmonicRatios& G, int steps, double measured) {
  return true_phase([&](double phi) { return distorted_phase(G, steps, phi); }, steps, measured);
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

Image<double> double_three_step_phase(const FrameViews& frames, int first) {
  const PhaseEquations three_steps(3);
  Image<double> phase(frames.size());
  frames.part(first, 6).visit([&](const auto& views) {
    for_each_row(phase.height(), [&](int row) {
      for (int column = 0; column < phase.width(); ++column) {
        const auto I = [&](std::size_t n) { return static_cast<double>(views[n](column, row)); };
        const double even = three_steps(std::array{I(0), I(2), I(4)}).wrapped_phase;
        const double odd = three_steps(std::array{I(1), I(3), I(5)}).wrapped_phase + pi / 3;
        const double half_apart = std::remainder(odd - even, 2 * pi) / 2;
        const std::complex<double> middle = std::polar(1.0, even + half_apart);
        phase(column, row) = wrapped_angle(middle.imag(), middle.real());
      }
    });
  });
  return phase;
}

}  // namespace slipstream
