#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {

/// Symbols side by side over the projector's field, each of which is known by its neighbours.
struct SymbolGrid {
  int columns = 0;                    ///< along the axis
  std::vector<std::uint8_t> symbols;  ///< row by row

  [[nodiscard]] int rows() const {
    return columns > 0 ? static_cast<int>(symbols.size()) / columns : 0;
  }
  friend bool operator==(const SymbolGrid&, const SymbolGrid&) = default;
};

/// Transitions from stripe to stripe, and symbols along each side of a square, that say where they
/// are.
inline constexpr int stripe_window = 4, symbol_window = 3;

/// One row of stripes, each of one or two of three channels (bits of 1, 2 and 4), of which each
/// shares a lit one with the next; what rises and falls over stripe_window transitions comes once.
/// Throws Error for less than 8 or more than 256.
SymbolGrid coloured_stripes(int stripes);
/// Symbols 0 to 2, each square of symbol_window a side of which comes once. Throws Error for less
/// than 8 along a side or more than 4096.
SymbolGrid symbol_array(int columns, int rows);

/// Symbol 0 is round, 1 long along the axis and 2 long across it: in [0, 1], at a place of its
/// cell, from -0.5 to 0.5.
double symbol_shape(int symbol, double along, double across);
/// What the grid shows: of stripes channel n, with the slopes of a sinusoid between their middles;
/// of symbols the only frame.
double grid_intensity(const SymbolGrid& grid, int n, double y, double across);

/// A frame that nothing shows: it is taken out of the spectrum of frames that hold several things
/// at once, each around a carrier of its own.
struct SpectralFrame {
  enum class Kind {
    mean,      ///< what is left without the carriers
    sinusoid,  ///< the mean and B / 2 cos(phi - angle) of the carrier's phase phi: half of B, for
               ///< no level is below 0, and the local mean may be below B
    envelope,  ///< how strong the carrier is
  };

  Kind kind = Kind::mean;
  double periods = 1;   ///< of the carrier, across the field
  bool across = false;  ///< the carrier runs across the axis, not along it
  double angle = 0;     ///< rad
  double share = 1;     ///< of the modulation: of the carrier; levels are those of a full one

  friend bool operator==(const SpectralFrame&, const SpectralFrame&) = default;
};

/// How frames that are shown become those that are read.
struct Demodulation {
  int shown = 1;  ///< frames; of two the second has all carriers half a period on
  std::vector<SpectralFrame> frames{};
  /// Where not empty, what is shown: of three frames stripes, of one symbols, by which every pixel
  /// has a place in the field, and all carriers their phases.
  SymbolGrid grid{};

  friend bool operator==(const Demodulation&, const Demodulation&) = default;
};

/// Sine, cosine and mean of a carrier along the axis, and the band that they make from frame
/// `first` of `frames` on.
std::vector<SpectralFrame> sine_cosine_mean(double periods, double share = 1);
Band sine_cosine_mean_band(int frames, int first, double periods, const Shifts& shifts = {});
/// What would show frame n of these three: in [0, 1].
double sine_cosine_mean_shape(int n, double periods, double y, const Shifts& shifts = {});

}  // namespace slipstream
