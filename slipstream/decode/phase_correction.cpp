#include "slipstream/decode/phase_correction.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

void require_valid(const PhaseCorrection& correction, int steps) {
  if (correction.steps != steps || steps < 3) {
    throw Error(
        fmt::format("the phase correction of {} steps stands at {}; both are one N, 3 or more",
                    correction.steps, steps));
  }
  const bool finite = std::all_of(correction.added.begin(), correction.added.end(),
                                  [](double added) { return std::isfinite(added); });
  if (correction.added.empty() || !finite) {
    throw Error(fmt::format("the phase correction of {} steps is empty or not finite", steps));
  }
}

double corrected_phase(const PhaseCorrection& correction, double phi) {
  constexpr double two_pi = 2 * std::numbers::pi;
  const std::size_t count = correction.added.size();
  const double place = phi * correction.steps / two_pi * static_cast<double>(count);
  const double floor = std::floor(place);
  const std::size_t left = static_cast<std::size_t>(floor) % count;
  const std::size_t right = (left + 1) % count;
  const double added = std::lerp(correction.added[left], correction.added[right], place - floor);
  const double corrected = phi + added;
  if (corrected < 0) return std::min(corrected + two_pi, std::nextafter(two_pi, 0));
  return corrected < two_pi ? corrected : corrected - two_pi;
}

}  // namespace slipstream
