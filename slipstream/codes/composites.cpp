#include "slipstream/codes/composites.h"

#include <cstddef>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
ShownSinusoid shown_in_frames(double periods, double share, const std::vector<double>& degrees,
                              const Shifts& shifts) {
  ShownSinusoid sinusoid{.periods = periods, .share = share};
  for (const double angle : degrees) {
    sinusoid.angle.push_back(angle * std::numbers::pi / 180);
    sinusoid.shown.push_back(angle == angle);
  }
  return turned(std::move(sinusoid), shifts);
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
    low.push_back(360 * moved);
    high.push_back(360 * N * moved);
  }
  return {shown_in_frames(N, share, high, shifts), shown_in_frames(1, 1 - share, low, shifts)};
}

void TwoFrequency4N::require_valid() const {
  if (periods.size() < 2 || periods.size() > 8) {
    throw Error(fmt::format("two-frequency-4n: {} periods are given; 2 to 8", periods.size()));
  }
  for (const double frequency : periods) {
    slipstream::require_valid(Sinusoid{.frequency = frequency}, "two-frequency-4n");
  }
}

std::vector<ShownSinusoid> TwoFrequency4N::sinusoids() const {
  const std::size_t count = periods.size();
  std::vector<ShownSinusoid> sinusoids;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double> angles(4 * count);
    for (std::size_t step = 0; step < 4; ++step) {
      angles[4 * i + step] = 90 * static_cast<double>(step);
    }
    sinusoids.push_back(
        shown_in_frames(periods[i], 1 / static_cast<double>(count), angles, shifts));
  }
  return sinusoids;
}

}  // namespace slipstream
