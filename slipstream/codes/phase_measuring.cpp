#include "slipstream/codes/phase_measuring.h"

#include "slipstream/codes/sinusoid.h"

namespace slipstream {

void PhaseMeasuring::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, frequency}, "pmp");
}

double PhaseMeasuring::shape(int n, double y) const {
  return sinusoid_intensity({steps, frequency, shifts}, n, y);
}

Layout PhaseMeasuring::layout() const {
  return {.frames = steps, .bands = {phase_shifted_band(steps, 0, steps, frequency, 1, 1, shifts)}};
}

}  // namespace slipstream
