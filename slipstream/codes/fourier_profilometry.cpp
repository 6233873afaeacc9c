#include "slipstream/codes/fourier_profilometry.h"

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {

void FourierProfilometry::require_valid() const {
  slipstream::require_valid(Sinusoid{.frequency = frequency}, "fourier");
  constexpr double fewest = 8;  // below, they are no carrier
  if (frequency < fewest) {
    throw Error(
        fmt::format("fourier: frequency {} is out of range; {} or more", frequency, fewest));
  }
  // Beyond, the carriers are too near to each other, or to each other's harmonics.
  constexpr double largest = 0.45;  // of the frequency
  if (low && !(*low >= fewest && *low <= largest * frequency)) {
    throw Error(fmt::format("fourier: low {} is out of range; from {} to {} of the frequency", *low,
                            fewest, largest));
  }
}

double FourierProfilometry::shape(int n, double y) const {
  const double intensity = sinusoid_intensity({2, frequency, shifts}, n, y);
  return low ? (intensity + sinusoid_intensity({2, *low, shifts}, n, y)) / 2 : intensity;
}

Demodulation FourierProfilometry::demodulation() const {
  Demodulation how{.shown = pi_shift ? 2 : 1, .frames = sine_cosine_mean(frequency, low ? 0.5 : 1)};
  if (low) {
    for (const SpectralFrame& frame : sine_cosine_mean(*low, 0.5)) how.frames.push_back(frame);
  }
  return how;
}

double FourierProfilometry::read_shape(int n, double y) const {
  return sine_cosine_mean_shape(n % 3, n < 3 ? frequency : *low, y, shifts);
}

Layout FourierProfilometry::layout() const {
  if (!low) return {.frames = 3, .bands = {sine_cosine_mean_band(3, 0, frequency, shifts)}};
  return {.frames = 6,
          .bands = {sine_cosine_mean_band(6, 0, frequency, shifts),
                    sine_cosine_mean_band(6, 3, *low, shifts)},
          .unwrapping = Unwrapping::surfaces};
}

}  // namespace slipstream
