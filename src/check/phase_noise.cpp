#include "check/phase_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/numbers.h"
#include "base/statistics.h"
#include "codes/predicted_variance.h"
#include "decode/cue_evidence.h"

namespace slipstream {

PhaseNoise phase_noise(const FrameModel& model, const JudgedScan& scan) {
  const Band& band = model.layout().bands[model.measuring_band()];
  const double variance = scan.photometry.noise_variance.value_or(CueSettings{}.noise_variance);
  const double of_level = std::sqrt(phase_variance(band, 1, variance));

  SampleReading reading;
  std::vector<double> modulations;
  const std::size_t groups = std::min(scan.samples.groups(), ScanSamples::fewest_groups);

  for (std::size_t g = 0; g < groups; ++g) {
    model.read(scan.samples.levels(g, ScanSamples::middle), model.identity(), reading);
    modulations.push_back(std::max(1.0, reading.modulation[model.measuring_band()]));
  }

  // Uniform over a pixel.
  const int length = length_along(scan.sequence.axis, scan.sequence.projector);
  const double by_pixel = two_pi * band.periods / (length > 0 ? length : 1024) / std::sqrt(12);

  return {of_level, of_level / quantile(modulations, 0.5), by_pixel};
}

}  // namespace slipstream
