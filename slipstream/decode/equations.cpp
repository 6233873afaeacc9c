#include "slipstream/decode/equations.h"

#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

constexpr std::array<ClosedForm, 3> closed_forms{{
    {.steps = 3, .u = {2, -1, -1}, .v = {0, 1, -1}, .divisor = 3, .sine_square = 3},
    {.steps = 4, .u = {1, 0, -1, 0}, .v = {0, 1, 0, -1}, .divisor = 2, .sine_square = 1},
    {.steps = 6,
     .u = {2, 1, -1, -2, -1, 1},
     .v = {0, 1, 1, 0, -1, -1},
     .divisor = 6,
     .sine_square = 3},
}};

}  // namespace

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

const ClosedForm* closed_form(int steps) {
  for (const ClosedForm& form : closed_forms) {
    if (form.steps == steps) return &form;
  }
  return nullptr;
}

double reflectivity(double modulation, double alpha_p, double share) {
  return 2 * modulation / (alpha_p * share);
}

double ambient_light(double mean, double alpha, const PatternLight& light) {
  return (mean - alpha * (light.alpha_p / 2 + light.beta_p)) / (alpha + 1);
}

double least_beta_p(double alpha, double ambient) {
  return ambient < 0 ? -(1 + 1 / alpha) * ambient : 0;
}

double least_reliable_reflectivity(double beta_p, double ambient) {
  if (ambient >= 0) return 0;
  const double lift = beta_p + ambient;
  return lift > 0 ? -ambient / lift : std::numeric_limits<double>::infinity();
}

double weighted_reflectivity(double alpha_1, double alpha_2, double c1) {
  return c1 * alpha_1 + (1 - c1) * alpha_2;
}

}  // namespace slipstream
