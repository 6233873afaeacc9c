#include "slipstream/decode/equations.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

using std::numbers::pi;

PhaseEquations::PhaseEquations(int steps) {
  if (steps < 3) throw Error(fmt::format("{} steps are too few; phase needs 3 or more", steps));
  for (int n = 0; n < steps; ++n) {
    sines_.push_back(std::sin(2 * pi * n / steps));
    cosines_.push_back(std::cos(2 * pi * n / steps));
  }
}

PhaseSample PhaseEquations::operator()(std::span<const double> I) const {
  const std::size_t N = sines_.size();
  double sum = 0, S = 0, C = 0;
  for (std::size_t n = 0; n < N; ++n) {
    sum += I[n];
    S += I[n] * sines_[n];
    C += I[n] * cosines_[n];
  }
  S *= 2.0 / static_cast<double>(N);               // (1.5)
  C *= 2.0 / static_cast<double>(N);               // (1.6)
  return {.mean = sum / static_cast<double>(N),    // (1.3)
          .modulation = std::sqrt(S * S + C * C),  // (1.4)
          .wrapped_phase = wrapped_angle(S, C)};   // (1.7)
}

double wrapped_angle(double S, double C) {
  if (std::abs(S) < 1e-12 && std::abs(C) < 1e-12) return 0;
  double angle = std::atan2(S, C);
  if (angle < 0) angle += 2 * pi;
  return angle > 2 * pi - 1e-12 ? 0.0 : angle;
}

double wrapped_sum(double a, double b) {
  return wrapped_angle(std::sin(a + b), std::cos(a + b));
}

}  // namespace slipstream
