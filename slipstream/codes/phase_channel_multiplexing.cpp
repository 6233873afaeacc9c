#include "slipstream/codes/phase_channel_multiplexing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {

namespace {

using std::numbers::pi;

CueReference published_reference(int steps) {
  return CueReference(steps == 3 ? CueReference::Form::linear : CueReference::Form::cosine);
}

}  // namespace

double PhaseChannelMultiplexing::f_h() const {
  return high.value_or(steps == 3 ? 3 : steps == 4 ? 6 : 12);
}

double PhaseChannelMultiplexing::c1() const {
  return share.value_or(steps == 3 ? 0.5 : 0.6);
}

void PhaseChannelMultiplexing::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, f_h()}, "pcmp");
  if (f_h() < 2 || f_h() != std::floor(f_h()) || f_h() > 1e6) {
    throw Error(fmt::format(
        "pcmp: high frequency {} is out of range; a whole number of periods, 2 or more", f_h()));
  }
  if (!(c1() > 1 / f_h() && c1() < 1)) {
    throw Error(
        fmt::format("pcmp: share {} of the high frequency is out of range; above 1 / {} = {:.4g}, "
                    "where it begins to pay (Eq. 3.64), and below 1",
                    c1(), f_h(), 1 / f_h()));
  }
  if (steps < 5) static_cast<void>(cue_reference());
}

CueReference PhaseChannelMultiplexing::cue_reference() const {
  return reference ? CueReference(reference) : published_reference(steps);
}

double PhaseChannelMultiplexing::shape(int n, double y) const {
  const double N = steps;
  const double main = std::cos(shifted_phase(shifts, 2 * pi * f_h() * y) - 2 * pi * n / N);
  const auto R = [&] {
    return reference ? reference(std::clamp(y, 0.0, 1.0)) : published_reference(steps)(y);
  };
  const double cue = steps == 3 ? R()  // (3.53)
                     : steps == 4
                         ? (n % 2 == 0 ? R() : -R())                                      // (3.68)
                         : std::cos(shifted_phase(shifts, 2 * pi * y) - 4 * pi * n / N);  // (3.83)
  return 0.5 + 0.5 * c1() * main + 0.5 * c2() * cue;
}

Layout PhaseChannelMultiplexing::layout() const {
  Layout layout{.frames = steps,
                .bands = {phase_shifted_band(steps, 0, steps, f_h(), 1, c1(), shifts)},
                .unwrapping = Unwrapping::vote};
  if (steps >= 5) {
    layout.bands.push_back(phase_shifted_band(steps, 0, steps, 1, 2, c2(), shifts));
  } else {
    layout.cue = Cue{.share = c2(),
                     .weights = steps == 3 ? mean_weights(3) : half_phase_weights(),
                     .reference = cue_reference()};
  }
  return layout;
}

}  // namespace slipstream
