#include "slipstream/codes/composite_pattern.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {

using std::numbers::pi;

void CompositePattern::require_valid() const {
  constexpr double fewest = 8;  // periods; below, they are no carrier
  constexpr std::size_t most_carriers = 8;
  slipstream::require_valid(Sinusoid{steps(), low}, "composite");
  slipstream::require_valid(Sinusoid{.frequency = high}, "composite");
  const bool spread = std::all_of(carriers.begin(), carriers.end(), [&](double periods) {
    return periods >= fewest && std::isfinite(periods);
  });
  if (!(high >= fewest) || !spread || carriers.size() > most_carriers) {
    throw Error(
        fmt::format("composite: high and carriers are {} periods or more, of 3 to {} carriers",
                    fewest, most_carriers));
  }
  if (!(share > 0 && share < 1)) {
    throw Error(fmt::format("composite: share {} is out of range; above 0, below 1", share));
  }
}

double CompositePattern::shape(int, double y, double across) const {
  double sum = share * std::cos(2 * pi * high * y);
  for (int n = 0; n < steps(); ++n) {
    const double carrier = std::cos(2 * pi * carriers[static_cast<std::size_t>(n)] * across);
    sum += (1 - share) / steps() * read_shape(n, y) * carrier;
  }
  return 0.5 + 0.5 * sum;
}

Demodulation CompositePattern::demodulation() const {
  using Kind = SpectralFrame::Kind;
  Demodulation how{.shown = 1, .frames = {}};
  for (const double periods : carriers) {
    how.frames.push_back({.kind = Kind::envelope,
                          .periods = periods,
                          .across = true,
                          .share = (1 - share) / steps()});
  }
  const std::vector<SpectralFrame> measuring = sine_cosine_mean(high, share);
  how.frames.insert(how.frames.end(), measuring.begin(), measuring.end());
  return how;
}

double CompositePattern::read_shape(int n, double y) const {
  if (n < steps()) return sinusoid_intensity({steps(), low}, n, y);
  return sine_cosine_mean_shape(n - steps(), high, y);
}

Layout CompositePattern::layout() const {
  const int frames = steps() + 3;
  Layout layout{.frames = frames,
                .bands = {sine_cosine_mean_band(frames, steps(), high)},
                .unwrapping = Unwrapping::surfaces};
  for (int n = 0; n < steps(); ++n) {
    layout.single_frames.push_back({n, low, -2 * pi * n / steps()});
  }
  return layout;
}

}  // namespace slipstream
