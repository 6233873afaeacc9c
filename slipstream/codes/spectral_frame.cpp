#include "slipstream/codes/spectral_frame.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace slipstream {

using std::numbers::pi;

std::vector<SpectralFrame> sine_cosine_mean(double periods, double share) {
  using Kind = SpectralFrame::Kind;
  const SpectralFrame cosine{.kind = Kind::sinusoid, .periods = periods, .share = share};
  SpectralFrame sine = cosine, mean = cosine;
  sine.angle = pi / 2;
  mean.kind = Kind::mean;
  return {sine, cosine, mean};
}

Band sine_cosine_mean_band(int frames, int first, double periods, const Shifts& shifts) {
  const auto count = static_cast<std::size_t>(frames), sine = static_cast<std::size_t>(first);
  const double turn = shifts.backwards ? -1 : 1;
  const double c = 2 * std::cos(shifts.origin), s = 2 * std::sin(shifts.origin);
  Band band{.periods = periods,
            .cosine = std::vector<double>(count),
            .sine = std::vector<double>(count),
            .mean = std::vector<double>(count)};
  // Each frame less the mean.
  const auto weigh = [&](std::vector<double>& weights, double of_sine, double of_cosine) {
    weights[sine] = of_sine;
    weights[sine + 1] = of_cosine;
    weights[sine + 2] = -(of_sine + of_cosine);
  };
  weigh(band.cosine, turn * s, c);
  weigh(band.sine, turn * c, -s);
  band.mean[sine + 2] = 1;
  return band;
}

double sine_cosine_mean_shape(int n, double periods, double y, const Shifts& shifts) {
  const double phase = 2 * pi * periods * y + shifts.origin;
  if (n == 0) return 0.5 + (shifts.backwards ? -0.25 : 0.25) * std::sin(phase);
  return n == 1 ? 0.5 + 0.25 * std::cos(phase) : 0.5;
}

}  // namespace slipstream
