#include "slipstream/codes/modulated_phase_shifting.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

using std::numbers::pi;

void ModulatedPhaseShifting::require_valid() const {
  constexpr std::size_t most_bases = 8;
  constexpr int most_carrier_steps = 16;
  if (periods.empty() || periods.size() > most_bases) {
    throw Error(
        fmt::format("modulated: {} periods are given; 1 to {}", periods.size(), most_bases));
  }
  for (const double f : periods) slipstream::require_valid(Sinusoid{steps, f}, "modulated");
  slipstream::require_valid(Sinusoid{3, carrier}, "modulated, carrier");
  const int M = carrier_steps.value_or(2);
  if (M < 2 || M > most_carrier_steps) {
    throw Error(fmt::format("modulated: {} carrier steps are out of range; 2 to {}", M,
                            most_carrier_steps));
  }
}

std::vector<ShownSinusoid> ModulatedPhaseShifting::sinusoids() const {
  const int M = carrier_steps.value_or(1), each = steps * carrier_steps.value_or(2);
  const std::size_t frames = static_cast<std::size_t>(each) * periods.size();
  std::vector<ShownSinusoid> sinusoids;
  for (std::size_t base = 0; base < periods.size(); ++base) {
    for (const int side : {1, -1}) {
      ShownSinusoid sinusoid{.periods = periods[base] / 2,
                             .share = carrier_steps ? 0.5 : 1,
                             .carrier = side * carrier,
                             .angle = std::vector<double>(frames),
                             .shown = std::vector<bool>(frames)};
      for (int i = 0; i < each; ++i) {
        const std::size_t frame =
            static_cast<std::size_t>(each) * base + static_cast<std::size_t>(i);
        const int n = i / M % steps, m = i % M;
        sinusoid.angle[frame] = 2 * pi * n / steps + side * pi * m / M;
        sinusoid.shown[frame] = carrier_steps || (i < steps) == (side > 0);
      }
      sinusoids.push_back(turned(std::move(sinusoid), shifts));
    }
  }
  return sinusoids;
}

}  // namespace slipstream
