#include "slipstream/strategy/fourier_profilometry.h"

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {

void FourierProfilometry::require_valid() const {
  slipstream::require_valid(Sinusoid{.frequency = frequency}, "fourier");
  constexpr double fewest = 8;  // below, they are no carrier
  if (frequency < fewest) {
    throw Error(
        fmt::format("fourier: frequency {} is out of range; {} or more", frequency, fewest));
  }
}

double FourierProfilometry::shape(int n, double y) const {
  return sinusoid_intensity({2, frequency, shifts}, n, y);
}

Demodulation FourierProfilometry::demodulation() const {
  return {.shown = pi_shift ? 2 : 1, .frames = sine_cosine_mean(frequency)};
}

double FourierProfilometry::read_shape(int n, double y) const {
  return sine_cosine_mean_shape(n, frequency, y, shifts);
}

Layout FourierProfilometry::layout() const {
  return {.frames = 3, .bands = {sine_cosine_mean_band(3, 0, frequency, shifts)}};
}

}  // namespace slipstream
