#include "slipstream/photometry/ambient_calibration.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/noise/reflectivity.h"
#include "slipstream/phase/phase_decoder.h"

namespace slipstream {

void require_ambient_measurable(const Sequence& sequence, const std::string& name) {
  if (sequence.strategy.layout().unwrapping != Unwrapping::vote) return;
  throw Error(fmt::format("{}: {}; ambient light is measured with patterns that hold no cue", name,
                          sequence.strategy.name()));
}

AmbientCalibration calibrate_ambient(const ScanAverage& scans, double least_alpha) {
  if (!(least_alpha > 0 && least_alpha <= 1)) {
    throw Error(
        fmt::format("--least-reflectivity {} is out of range; above 0, at most 1", least_alpha));
  }
  const Sequence& sequence = scans.sequence();
  const Band& band = sequence.strategy.layout().bands.front();
  const PhaseMaps maps = PhaseDecoder(PhaseMethod::equation, {})(scans.frames().mean(), band);
  const Image<double> map =
      ambient_map(maps.mean, maps.modulation, sequence.light, least_alpha, scans.unclipped());
  AmbientCalibration found{.estimate = ambient_estimate(map)};
  const double reach = std::max(1.0, 5 * std::sqrt(found.estimate.variance));
  found.histogram =
      histogram(map, found.estimate.median - reach, found.estimate.median + reach, 60);
  found.least_reliable_alpha =
      least_reliable_reflectivity(sequence.light.beta_p, found.estimate.mode);
  return found;
}

}  // namespace slipstream
