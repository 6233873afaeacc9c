#include "slipstream/strategy/phase_measuring.h"

#include <algorithm>
#include <utility>

#include "slipstream/noise/phase_noise.h"
#include "slipstream/pattern/sinusoid.h"
#include "slipstream/phase/temporal_unwrapping.h"

namespace slipstream {

void PhaseMeasuring::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, frequency}, "pmp");
}

double PhaseMeasuring::shape(int n, double y) const {
  return sinusoid_intensity({steps, frequency}, n, y);
}

DecodedScan PhaseMeasuring::decode(const FrameSet& frames, const PhaseDecoder& phase, int length,
                                   const CueSettings&) const {
  PhaseMaps maps = phase(frames, 0, steps);
  Image<double> coordinate;
  if (has_coordinate()) {
    coordinate = Image<double>(frames.size());
    std::transform(maps.wrapped_phase.begin(), maps.wrapped_phase.end(), coordinate.begin(),
                   [&](double phi) {
                     return coordinate_in_field(unwrapped_coordinate(phi, 0, frequency),
                                                1 / frequency, length);
                   });
  }
  return {.mean = std::move(maps.mean),
          .modulation = std::move(maps.modulation),
          .wrapped_phase = std::move(maps.wrapped_phase),
          .fringe_order_doubt = {},
          .coordinate = std::move(coordinate)};
}

double PhaseMeasuring::coordinate_variance(double alpha, double alpha_p,
                                           double noise_variance) const {
  return slipstream::coordinate_variance(phase_variance(steps, alpha, alpha_p, noise_variance),
                                         frequency);
}

}  // namespace slipstream
