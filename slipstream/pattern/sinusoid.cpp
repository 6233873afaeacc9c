#include "slipstream/pattern/sinusoid.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {

using std::numbers::pi;

double sinusoid_intensity(const Sinusoid& sinusoid, int n, double y) {
  const auto [N, f] = sinusoid;
  return 0.5 + 0.5 * std::cos(2 * pi * f * y - 2 * pi * n / N);
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
