#include "slipstream/codes/period_coded.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// g_n.
double carrier(int n, int steps) {
  const double g = std::cos(4 * pi * n / steps);
  return std::abs(g) < 1e-12 ? 0 : g;
}

double carrier_square(int steps) {
  double sum = 0;
  for (int n = 0; n < steps; ++n) sum += carrier(n, steps) * carrier(n, steps);
  return sum;
}

/// 1 - |cos|: what the sinusoid leaves on both sides of frame n and its opposite.
double room(int n, int steps, double phi) {
  return 1 - std::abs(std::cos(phi - 2 * pi * n / steps));
}

/// a(phi).
double most_amplitude(int steps, double phi) {
  double sum = 0;
  for (int n = 0; n < steps; ++n) sum += std::abs(carrier(n, steps)) * room(n, steps, phi);
  return sum / carrier_square(steps);
}

/// c_2: the least a(phi) of N = 4 and 8, and less than that of other N.
constexpr double cue_share = 1 - 1 / std::numbers::sqrt2;

}  // namespace

void PeriodCoded::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, high}, "pcps");
  if (steps % 2 != 0 || steps > 64) {
    throw Error(fmt::format("pcps: {} steps are out of range; even, 4 to 64", steps));
  }
  if (high < 2 || high != std::floor(high) || high > 1e6) {
    throw Error(fmt::format("pcps: {} periods are out of range; whole, 2 or more", high));
  }
}

double PeriodCoded::shape(int n, double y) const {
  const double phi = shifted_phase(shifts, 2 * pi * high * y);
  const double g = carrier(n, steps), sign = g > 0 ? 1 : g < 0 ? -1 : 0;
  const double r = 2 * std::clamp(y, 0.0, 1.0) - 1;
  const double added = r * cue_share / most_amplitude(steps, phi) * sign * room(n, steps, phi);
  return std::clamp(0.5 + 0.5 * (std::cos(phi - 2 * pi * n / steps) + added), 0.0, 1.0);
}

Layout PeriodCoded::layout() const {
  Layout layout{.frames = steps,
                .bands = {phase_shifted_band(steps, 0, steps, high, 1, 1, shifts)},
                .unwrapping = Unwrapping::vote};
  Cue cue{.share = cue_share};
  for (int n = 0; n < steps; ++n) cue.weights.push_back(carrier(n, steps) / carrier_square(steps));
  layout.cue = cue;
  return layout;
}

}  // namespace slipstream
