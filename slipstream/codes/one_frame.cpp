#include "slipstream/codes/one_frame.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

/// Frames of one period, and of so many that noise is that of an edge or a symbol.
Demodulation read_as_fringes(int shown, double periods, SymbolGrid grid) {
  Demodulation how{.shown = shown, .frames = sine_cosine_mean(periods), .grid = std::move(grid)};
  for (const SpectralFrame& frame : sine_cosine_mean(1)) how.frames.push_back(frame);
  return how;
}

Layout fringes(double periods) {
  return {.frames = 6,
          .bands = {sine_cosine_mean_band(6, 0, periods), sine_cosine_mean_band(6, 3, 1)},
          .unwrapping = Unwrapping::hierarchical};
}

}  // namespace

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

void DeBruijn::require_valid() const {
  coloured_stripes(stripes);
}

Demodulation DeBruijn::demodulation() const {
  return read_as_fringes(3, stripes / 2.0, coloured_stripes(stripes));
}

Layout DeBruijn::layout() const {
  return fringes(stripes / 2.0);  // with the slopes that theirs have
}

void SymbolArray::require_valid() const {
  symbol_array(columns, rows);
}

Demodulation SymbolArray::demodulation() const {
  return read_as_fringes(1, columns, symbol_array(columns, rows));
}

Layout SymbolArray::layout() const {
  return fringes(columns);
}

}  // namespace slipstream
