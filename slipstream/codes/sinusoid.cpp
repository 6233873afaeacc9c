#include "slipstream/codes/sinusoid.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

using std::numbers::pi;

double sinusoid_intensity(const Sinusoid& sinusoid, int n, double y) {
  const auto& [N, f, shifts] = sinusoid;
  return 0.5 + 0.5 * std::cos(shifted_phase(shifts, 2 * pi * f * y) - 2 * pi * n / N);
}

double shifted_phase(const Shifts& shifts, double phi) {
  return shifts.backwards ? -phi - shifts.origin : phi + shifts.origin;
}

double unshifted_phase(const Shifts& shifts, double shifted) {
  const double phi = (shifts.backwards ? -shifted : shifted) - shifts.origin;
  const double turned = phi - 2 * pi * std::floor(phi / (2 * pi));
  return turned > 2 * pi - 1e-12 ? 0 : turned;  // as wrapped_angle rounds
}

void require_valid(const Sinusoid& sinusoid, const char* name) {
  if (sinusoid.steps < 3 || sinusoid.steps > most_steps) {
    throw Error(fmt::format("{}: {} steps are out of range; a sinusoid takes 3 to {}", name,
                            sinusoid.steps, most_steps));
  }
  if (!std::isfinite(sinusoid.frequency) || sinusoid.frequency <= 0) {
    throw Error(fmt::format("{}: frequency {} is out of range; it is a positive number of periods",
                            name, sinusoid.frequency));
  }
}

}  // namespace slipstream
