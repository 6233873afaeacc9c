#include "slipstream/strategy/dual_frequency.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/image/parallel_rows.h"
#include "slipstream/noise/phase_noise.h"
#include "slipstream/pattern/sinusoid.h"
#include "slipstream/phase/temporal_unwrapping.h"

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
  return n < steps ? sinusoid_intensity({steps, high}, n, y)
                   : sinusoid_intensity({low_step_count(), low}, n - steps, y);
}

DecodedScan DualFrequency::decode(const FrameSet& frames, const PhaseDecoder& phase, int length,
                                  const CueSettings&) const {
  PhaseMaps fine = phase(frames, 0, steps);
  const PhaseMaps coarse = phase(frames, steps, low_step_count());
  Image<double> coordinate(frames.size());
  Image<double> doubt(frames.size());
  for_each_row(frames.size().height, [&](int row) {
    for (int column = 0; column < frames.size().width; ++column) {
      const double phi_h = fine.wrapped_phase(column, row);
      const double y_l = unwrapped_coordinate(coarse.wrapped_phase(column, row), 0, low);
      const int k = fringe_order(phi_h, high, y_l);
      doubt(column, row) = std::abs(fringe_order_residual(phi_h, high, y_l, k));
      coordinate(column, row) =
          coordinate_in_field(unwrapped_coordinate(phi_h, k, high), 1 / low, length);
    }
  });
  std::transform(fine.modulation.begin(), fine.modulation.end(), coarse.modulation.begin(),
                 fine.modulation.begin(), [](double a, double b) { return std::min(a, b); });
  return {.mean = std::move(fine.mean),
          .modulation = std::move(fine.modulation),
          .wrapped_phase = std::move(fine.wrapped_phase),
          .fringe_order_doubt = std::move(doubt),
          .coordinate = std::move(coordinate)};
}

double DualFrequency::coordinate_variance(double alpha, double alpha_p,
                                          double noise_variance) const {
  return slipstream::coordinate_variance(phase_variance(steps, alpha, alpha_p, noise_variance),
                                         high);
}

}  // namespace slipstream
