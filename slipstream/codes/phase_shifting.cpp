#include "slipstream/codes/phase_shifting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/unwrapping.h"

namespace slipstream {
namespace {

using std::numbers::pi;

constexpr std::array band_unwrappings{Unwrapping::hierarchical, Unwrapping::beats,
                                      Unwrapping::likelihood};

const Unwrapping* band_unwrapping_named(std::string_view name) {
  const auto* const found = std::find_if(band_unwrappings.begin(), band_unwrappings.end(),
                                         [&](Unwrapping way) { return way_of(way).name == name; });
  return found == band_unwrappings.end() ? nullptr : found;
}

/// The margin of the bands so unwrapped; 0 where they cannot be.
double margin_by(Layout layout, Unwrapping way) {
  layout.unwrapping = way;
  const bool begins = way == Unwrapping::hierarchical ? least_periods(layout) <= 1
                                                      : !unwrapping_chain(layout).empty();
  return begins ? unwrapping_margin(layout) : 0;
}

Unwrapping safest(const Layout& layout) {
  // A modulation of 40 grey levels, a noise of sigma_w^2 = 1.6.
  constexpr double enough = 6 * 1.26 / 40;
  Unwrapping best = Unwrapping::likelihood;
  double best_margin = 0;
  for (const Unwrapping way : band_unwrappings) {
    const double margin = margin_by(layout, way);
    if (margin >= enough) return way;
    if (margin > best_margin) std::tie(best, best_margin) = std::pair(way, margin);
  }
  return best;
}

/// Throws Error unless there are `least` to `most` periods.
void require_count(std::string_view name, const std::vector<double>& periods, std::size_t least,
                   std::size_t most) {
  if (periods.size() >= least && periods.size() <= most) return;
  throw Error(fmt::format("{}: {} periods are given; {} to {}", name, periods.size(), least, most));
}

/// N-step sinusoids one after the other.
Layout layout_of(std::span<const Sinusoid> runs, Unwrapping unwrapping) {
  Layout layout{.unwrapping = unwrapping};
  for (const Sinusoid& run : runs) layout.frames += run.steps;
  int first = 0;
  for (const Sinusoid& run : runs) {
    layout.bands.push_back(band_of(run, layout.frames, first));
    first += run.steps;
  }
  return layout;
}

constexpr int micro_steps = 3;

}  // namespace

void PhaseMeasuring::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, frequency}, "pmp");
}

double PhaseMeasuring::shape(int n, double y) const {
  return sinusoid_intensity({steps, frequency, shifts}, n, y);
}

Layout PhaseMeasuring::layout() const {
  return layout_of(std::array{Sinusoid{steps, frequency, shifts}}, Unwrapping::none);
}

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
  const std::array runs{Sinusoid{steps, high, shifts}, Sinusoid{low_step_count(), low, shifts}};
  return layout_of(runs, Unwrapping::hierarchical);
}

Sinusoid MultiFrequency::band(std::size_t i) const {
  return {steps.size() == 1 ? steps.front() : steps[i], periods[i], shifts};
}

void MultiFrequency::require_valid() const {
  require_count(name, periods, 1, 8);
  if (steps.size() != 1 && steps.size() != periods.size()) {
    throw Error(
        fmt::format("multi-frequency: {} steps for {} periods; one for all, or one for each",
                    steps.size(), periods.size()));
  }
  for (std::size_t i = 0; i < periods.size(); ++i) {
    slipstream::require_valid(band(i), "multi-frequency");
  }
  if (!unwrapping.empty() && band_unwrapping_named(unwrapping) == nullptr) {
    throw Error(fmt::format(
        "multi-frequency: unwrapping '{}' is none of hierarchical, heterodyne, number-theory",
        unwrapping));
  }
}

double MultiFrequency::shape(int n, double y) const {
  std::size_t i = 0;
  while (n >= band(i).steps) n -= band(i++).steps;
  return sinusoid_intensity(band(i), n, y);
}

Layout MultiFrequency::layout() const {
  std::vector<Sinusoid> runs;
  for (std::size_t i = 0; i < periods.size(); ++i) runs.push_back(band(i));
  Layout layout = layout_of(runs, Unwrapping::none);
  const Unwrapping* const asked = band_unwrapping_named(unwrapping);
  layout.unwrapping = asked != nullptr ? *asked : safest(layout);
  return layout;
}

void MicroPhaseShifting::require_valid() const {
  require_count(name, periods, 2, 64);
  for (const double f : periods) slipstream::require_valid(Sinusoid{micro_steps, f}, "micro");
}

double MicroPhaseShifting::shape(int n, double y) const {
  const int after = std::max(n - micro_steps + 1, 0);  // which of the periods
  const Sinusoid shown{micro_steps, periods[static_cast<std::size_t>(after)], shifts};
  return sinusoid_intensity(shown, after > 0 ? 0 : n, y);
}

Layout MicroPhaseShifting::layout() const {
  const int frames = micro_steps + static_cast<int>(periods.size()) - 1;
  Layout layout{.frames = frames,
                .bands = {band_of({micro_steps, periods.front(), shifts}, frames)},
                .unwrapping = Unwrapping::single_frames};
  for (std::size_t i = 1; i < periods.size(); ++i) {
    layout.single_frames.push_back(
        {micro_steps + static_cast<int>(i) - 1, periods[i], shifts.origin});
  }
  return layout;
}

void ModulatedPhaseShifting::require_valid() const {
  constexpr int most_carrier_steps = 16;
  require_count(name, periods, 1, 8);
  for (const double f : periods) slipstream::require_valid(Sinusoid{steps, f}, "modulated");
  slipstream::require_valid(Sinusoid{3, carrier}, "modulated, carrier");
  const int M = carrier_steps.value_or(2);
  if (M < 2 || M > most_carrier_steps) {
    throw Error(fmt::format("modulated: {} carrier steps are out of range; 2 to {}", M,
                            most_carrier_steps));
  }
}

std::vector<ShownSinusoid> ModulatedPhaseShifting::sinusoids() const {
  const int M = carrier_steps.value_or(1), each = steps * carrier_steps.value_or(2);
  const std::size_t frames = static_cast<std::size_t>(each) * periods.size();
  std::vector<ShownSinusoid> sinusoids;
  for (std::size_t base = 0; base < periods.size(); ++base) {
    for (const int side : {1, -1}) {
      ShownSinusoid sinusoid{.periods = periods[base] / 2,
                             .share = carrier_steps ? 0.5 : 1,
                             .carrier = side * carrier,
                             .angle = std::vector<double>(frames),
                             .shown = std::vector<bool>(frames)};
      for (int i = 0; i < each; ++i) {
        const std::size_t frame =
            static_cast<std::size_t>(each) * base + static_cast<std::size_t>(i);
        const int n = i / M % steps, m = i % M;
        sinusoid.angle[frame] = 2 * pi * n / steps + side * pi * m / M;
        sinusoid.shown[frame] = carrier_steps || (i < steps) == (side > 0);
      }
      sinusoids.push_back(turned(std::move(sinusoid), shifts));
    }
  }
  return sinusoids;
}

ShownSinusoid shown_in_frames(double periods, double share, const std::vector<double>& degrees,
                              const Shifts& shifts) {
  ShownSinusoid sinusoid{.periods = periods, .share = share};
  for (const double angle : degrees) {
    sinusoid.angle.push_back(angle * pi / 180);
    sinusoid.shown.push_back(angle == angle);
  }
  return turned(std::move(sinusoid), shifts);
}

void TwoFrequency2N::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, 1.0 * steps}, "two-frequency-2n");
  if (!(share > 0 && share < 1)) {
    throw Error(fmt::format("two-frequency-2n: share {} is out of range; above 0, below 1", share));
  }
}

std::vector<ShownSinusoid> TwoFrequency2N::sinusoids() const {
  const double N = steps;
  std::vector<double> high, low;
  for (int n = 0; n < 2 * steps; ++n) {
    const double moved = n < N ? n / N : (n - N) / (N * N);  // in parts of the long period
    low.push_back(360 * moved);
    high.push_back(360 * N * moved);
  }
  return {shown_in_frames(N, share, high, shifts), shown_in_frames(1, 1 - share, low, shifts)};
}

void TwoFrequency4N::require_valid() const {
  require_count(name, periods, 2, 8);
  for (const double f : periods) {
    slipstream::require_valid(Sinusoid{.frequency = f}, "two-frequency-4n");
  }
}

std::vector<ShownSinusoid> TwoFrequency4N::sinusoids() const {
  const std::size_t count = periods.size();
  std::vector<ShownSinusoid> sinusoids;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<double> angles(4 * count);
    for (std::size_t step = 0; step < 4; ++step) {
      angles[4 * i + step] = 90 * static_cast<double>(step);
    }
    sinusoids.push_back(
        shown_in_frames(periods[i], 1 / static_cast<double>(count), angles, shifts));
  }
  return sinusoids;
}

}  // namespace slipstream
