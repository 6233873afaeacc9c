#include "slipstream/phase_channel_multiplexing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

using std::numbers::pi;

CueReference published_reference(int steps) {
  return CueReference(steps == 3 ? CueReference::Form::linear : CueReference::Form::cosine);
}

/// g_n.
double carrier(int n, int steps) {
  const double g = std::cos(4 * pi * n / steps);
  return std::abs(g) < 1e-12 ? 0 : g;
}

double carrier_square(int steps) {
  double sum = 0;
  for (int n = 0; n < steps; ++n) sum += carrier(n, steps) * carrier(n, steps);
  return sum;
}

/// 1 - |cos|: the headroom of frame n and its opposite beside the sinusoid.
double room(int n, int steps, double phi) {
  return 1 - std::abs(std::cos(phi - 2 * pi * n / steps));
}

/// c_2: the minimum of a(phi) for N = 4 and 8, and below the minimum for other N.
constexpr double cue_share = 1 - 1 / std::numbers::sqrt2;

}  // namespace

void PhaseChannelMultiplexing::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, f_h()}, "pcmp");

  throw_if(f_h() < 2 || f_h() != std::floor(f_h()) || f_h() > 1e6,
           "pcmp: high frequency {} is out of range; expected a whole number of periods, 2 or more",
           f_h());

  throw_if(!(c1() > 1 / f_h() && c1() < 1),
           "pcmp: share {} of the high frequency is out of range; above 1 / {} = {:.4g} "
           "(Eq. 3.64), below 1",
           c1(), f_h(), 1 / f_h());

  // Making the reference checks it.
  if (steps < 5) static_cast<void>(cue_reference());
}

CueReference PhaseChannelMultiplexing::cue_reference() const {
  return reference ? CueReference(reference) : published_reference(steps);
}

double PhaseChannelMultiplexing::shape(int n, double y) const {
  const double N = steps;
  const double main = std::cos(shifted_phase(shifts, 2 * pi * f_h() * y) - 2 * pi * n / N);

  // The cue: in the DC channel, the half phase channel or the second phase channel.
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
                .bands = {band_of({steps, f_h(), shifts}, steps, 0, c1())},
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

void PeriodCoded::require_valid() const {
  slipstream::require_valid(Sinusoid{steps, high}, "pcps");
  throw_if(steps % 2 != 0 || steps > 64, "pcps: {} steps are out of range; an even number, 4 to 64",
           steps);
  throw_if(high < 2 || high != std::floor(high) || high > 1e6,
           "pcps: {} periods are out of range; a whole number, 2 or more", high);
}

double PeriodCoded::shape(int n, double y) const {
  const double phi = shifted_phase(shifts, 2 * pi * high * y);
  const double g = carrier(n, steps), sign = g > 0 ? 1 : g < 0 ? -1 : 0;
  const double r = 2 * std::clamp(y, 0.0, 1.0) - 1;

  // Divided by a(phi), the cue reads as c_2 r at every phase.
  double sum = 0;
  for (int k = 0; k < steps; ++k) sum += std::abs(carrier(k, steps)) * room(k, steps, phi);
  const double most_amplitude = sum / carrier_square(steps);  // a(phi)
  const double added = r * cue_share / most_amplitude * sign * room(n, steps, phi);

  return std::clamp(0.5 + 0.5 * (std::cos(phi - 2 * pi * n / steps) + added), 0.0, 1.0);
}

Layout PeriodCoded::layout() const {
  Layout layout{.frames = steps,
                .bands = {band_of({steps, high, shifts}, steps)},
                .unwrapping = Unwrapping::vote};

  Cue cue{.share = cue_share};
  for (int n = 0; n < steps; ++n) cue.weights.push_back(carrier(n, steps) / carrier_square(steps));
  layout.cue = cue;

  return layout;
}

}  // namespace slipstream
