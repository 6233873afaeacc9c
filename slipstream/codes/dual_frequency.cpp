#include "slipstream/codes/dual_frequency.h"

#include <cmath>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {

void DualFrequency::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, high}, "dual-frequency, high");
  slipstream::require_valid(Sinusoid{low_step_count(), low}, "dual-frequency, low");
  if (low > 1) {
    throw Error(fmt::format(
        "dual-frequency: low frequency {} is out of range; at most 1 period covers the field",
        low));
  }
  const double ratio = high / low;
  if (ratio < 1 || std::abs(ratio - std::round(ratio)) > 1e-9) {
    throw Error(fmt::format(
        "dual-frequency: high frequency {} does not fit; it is a whole multiple of the low one, {}",
        high, low));
  }
}

double DualFrequency::shape(int n, double y) const {
  return n < steps ? sinusoid_intensity({steps, high, shifts}, n, y)
                   : sinusoid_intensity({low_step_count(), low, shifts}, n - steps, y);
}

Layout DualFrequency::layout() const {
  const int low_count = low_step_count(), frames = steps + low_count;
  return {.frames = frames,
          .bands = {phase_shifted_band(frames, 0, steps, high, 1, 1, shifts),
                    phase_shifted_band(frames, steps, low_count, low, 1, 1, shifts)},
          .unwrapping = Unwrapping::hierarchical};
}

}  // namespace slipstream
