#pragma once

#include <string_view>
#include <vector>

#include "slipstream/codes/layout.h"

namespace slipstream {

/// One run of phase-shifted sinusoids: `steps` (N) patterns of `frequency` (f) periods across the
/// projector field.
struct Sinusoid {
  int steps = 3;
  double frequency = 1;
  Shifts shifts{};
};

/// More frames than this for one sinusoid are a mistake in a settings file.
inline constexpr int most_steps = 4096;

/// Intensity of pattern n at projector coordinate y, between 0 and 1: the bracket of Liu 2010,
/// Eq. (3.1), 1/2 + 1/2 cos(2 pi f y - 2 pi n / N), the phase as Shifts has it. With A^p = B^p it
/// is Eq. (1.1) up to scale.
double sinusoid_intensity(const Sinusoid& sinusoid, int n, double y);

/// Throws Error unless 3 <= steps <= most_steps and frequency is finite and positive. `name` is
/// what the message calls the sinusoid.
void require_valid(const Sinusoid& sinusoid, const char* name);

/// Its first phase channel in frames from `first` on of `frames`.
Band band_of(const Sinusoid& sinusoid, int frames, int first = 0, double share = 1);

/// The settings that every coding of sinusoids has, so that patterns made elsewhere can be
/// described: see Strategy.
template <class AnyShifts, class Visit>
void visit_shifts(AnyShifts& shifts, const Visit& visit) {
  visit("origin", "phase of the first frame at the field's edge, rad", shifts.origin);
  visit("backwards", "phases fall from frame to frame by what else they rise", shifts.backwards);
}

/// A sinusoid as frames show it, alone or with others in the same frames.
struct ShownSinusoid {
  double periods = 1;
  double share = 1;             ///< of the modulation; those of all together at most 1
  double carrier = 0;           ///< periods across the axis
  std::vector<double> angle{};  ///< shift in each frame, rad: cos(2 pi (f y + carrier across) -
                                ///< angle)
  std::vector<bool> shown{};    ///< whether it is in the frame at all
};

/// The same with origin and direction of its shifts: angle - origin, or - angle - origin.
ShownSinusoid turned(ShownSinusoid sinusoid, const Shifts& shifts);

/// Intensity of frame n at y and `across` in [0, 1]: 1/2 and half of each sinusoid.
double composite_intensity(const std::vector<ShownSinusoid>& sinusoids, int n, double y,
                           double across = 0);

/// Weights that take each sinusoid's C and S and the mean out of frames that show them together,
/// those of least noise: the pseudo-inverse of what the frames are made of. Of a sinusoid with a
/// carrier and the next one, its mirror image with a carrier of as many periods less than 0, one
/// band is made: see Band::carrier. Throws Error, beginning with `name`, where they cannot be told
/// apart.
std::vector<Band> fitted_bands(const std::vector<ShownSinusoid>& sinusoids, std::string_view name);

}  // namespace slipstream
