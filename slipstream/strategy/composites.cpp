#include "slipstream/strategy/composites.h"

#include <cstddef>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// Shown in all frames but those whose angle is NaN.
ShownSinusoid shown(double periods, double share, std::vector<double> angles,
                    const Shifts& shifts) {
  ShownSinusoid sinusoid{.periods = periods, .share = share, .angle = std::move(angles)};
  for (const double angle : sinusoid.angle) sinusoid.shown.push_back(angle == angle);
  return turned(std::move(sinusoid), shifts);
}

constexpr double degrees(double angle) {
  return angle * pi / 180;
}

void require_frequency(std::string_view name, double frequency) {
  slipstream::require_valid(Sinusoid{.frequency = frequency}, std::string(name).c_str());
}

}  // namespace

void TwoPlusOne::require_valid() const {
  require_frequency(name, frequency);
}

std::vector<ShownSinusoid> TwoPlusOne::sinusoids() const {
  constexpr double not_shown = std::numeric_limits<double>::quiet_NaN();
  return {shown(frequency, 1, {degrees(90), 0, not_shown}, shifts)};
}

void FastThreeStep::require_valid() const {
  require_frequency(name, frequency);
}

std::vector<ShownSinusoid> FastThreeStep::sinusoids() const {
  return {shown(frequency, 1, {degrees(120), 0, degrees(-120)}, shifts)};
}

void DoubleThreeStep::require_valid() const {
  require_frequency(name, frequency);
}

std::vector<ShownSinusoid> DoubleThreeStep::sinusoids() const {
  return {shown(frequency, 1,
                {0, degrees(120), degrees(240), degrees(60), degrees(180), degrees(300)}, shifts)};
}

void TwoFrequency2N::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, 1.0 * steps}, "two-frequency-2n");
  if (!(share > 0 && share < 1)) {
    throw Error(fmt::format("two-frequency-2n: share {} is out of range; above 0, below 1", share));
  }
}

std::vector<ShownSinusoid> TwoFrequency2N::sinusoids() const {
  const double N = steps;
  std::vector<double> high, low;
  for (int n = 0; n < 2 * steps; ++n) {
    const double moved = n < N ? n / N : (n - N) / (N * N);  // in parts of the long period
    low.push_back(2 * pi * moved);
    high.push_back(2 * pi * N * moved);
  }
  return {shown(N, share, high, shifts), shown(1, 1 - share, low, shifts)};
}

void TwoFrequency4N::require_valid() const {
  if (periods.size() < 2 || periods.size() > 8) {
    throw Error(fmt::format("two-frequency-4n: {} periods are given; 2 to 8", periods.size()));
  }
  for (const double frequency : periods) require_frequency(name, frequency);
}

std::vector<ShownSinusoid> TwoFrequency4N::sinusoids() const {
  const std::size_t count = periods.size();
  std::vector<ShownSinusoid> sinusoids;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double> angles(4 * count);
    for (std::size_t step = 0; step < 4; ++step) {
      angles[4 * i + step] = degrees(90) * static_cast<double>(step);
    }
    sinusoids.push_back(shown(periods[i], 1 / static_cast<double>(count), angles, shifts));
  }
  return sinusoids;
}

}  // namespace slipstream
