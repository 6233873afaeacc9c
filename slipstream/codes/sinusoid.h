#pragma once

namespace slipstream {

/// Where a run's phase begins and which way its shifts go: pattern n has the phase 2 pi f y +
/// origin
/// - 2 pi n / N, or + 2 pi n / N backwards.
struct Shifts {
  double origin = 0;  ///< rad, at the edge of the field, y = 0
  bool backwards = false;

  friend bool operator==(const Shifts&, const Shifts&) = default;
};

/// The phase as the N equations (1.5), (1.6) see it, which know of no such shifts; rad, any.
double shifted_phase(const Shifts& shifts, double phi);
/// The phase from what they see, rad, [0, 2 pi).
double unshifted_phase(const Shifts& shifts, double shifted);

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

}  // namespace slipstream
