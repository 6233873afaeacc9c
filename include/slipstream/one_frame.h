#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "slipstream/phase_shifting.h"

namespace slipstream {

/// A grid of symbols over the projector's field, each identified by its neighbours.
struct SymbolGrid {
  int columns = 0;                    ///< along the axis
  std::vector<std::uint8_t> symbols;  ///< row by row

  [[nodiscard]] int rows() const {
    return columns > 0 ? static_cast<int>(symbols.size()) / columns : 0;
  }

  friend bool operator==(const SymbolGrid&, const SymbolGrid&) = default;
};

/// Number of successive transitions, and side of a square of symbols, that are unique.
inline constexpr int stripe_window = 4, symbol_window = 3;

/// A row of stripes, each lit in one or two of three channels (bits 1, 2 and 4), one shared with
/// the next stripe; any stripe_window transitions are unique. Throws Error unless there are 8 to
/// 256.

SymbolGrid coloured_stripes(int stripes);
/// Symbols 0 to 2 in which every square with side symbol_window is unique. Throws Error for a side
/// below 8 or above 4096.
SymbolGrid symbol_array(int columns, int rows);

/// Intensity of the grid: stripes of channel n, with sinusoidal slopes between their centres; or
/// symbols.
double grid_intensity(const SymbolGrid& grid, int n, double y, double across);

/// A frame extracted from the spectrum of frames that multiplex patterns on different carriers.
struct SpectralFrame {
  enum class Kind {
    mean,      ///< the frame without the carriers
    sinusoid,  ///< mean and B / 2 cos(phi - angle) of the carrier's phase phi: only half of B, as
               ///< no level is below 0 and the local mean may be below B
    envelope,  ///< amplitude of the carrier
  };

  Kind kind = Kind::mean;
  double periods = 1;   ///< of the carrier, across the field
  bool across = false;  ///< the carrier runs across the axis instead of along it
  double angle = 0;     ///< rad
  double share = 1;     ///< the carrier's share of the modulation; levels are scaled to a full one

  friend bool operator==(const SpectralFrame&, const SpectralFrame&) = default;
};

/// How displayed frames become the frames that are decoded.
struct Demodulation {
  int shown = 1;  ///< displayed frames; a second one has all carriers shifted by half a period
  std::vector<SpectralFrame> frames{};
  /// Optional: the displayed grid, stripes in three frames or symbols in one. It gives pixels their
  /// positions in the field, and all carriers their phases.
  SymbolGrid grid{};

  friend bool operator==(const Demodulation&, const Demodulation&) = default;
};

/// Sine, cosine and mean of a carrier along the axis, and their band from frame `first` on.
std::vector<SpectralFrame> sine_cosine_mean(double periods, double share = 1);
Band sine_cosine_mean_band(int frames, int first, double periods, const Shifts& shifts = {});

/// The pattern that would show frame n of these three: in [0, 1].
double sine_cosine_mean_shape(int n, double periods, double y, const Shifts& shifts = {});

/// Fourier transform profilometry: the phase of one frame of many periods, from its place in the
/// spectrum (Takeda and Mutoh 1983, Section 1.2); or from two frames, the second shifted by half a
/// period, which removes the mean (Li et al. 1990). A second carrier gives each surface the order
/// for which both phases agree (Takeda et al. 1997). See Demodulator.
struct FourierProfilometry {
  static constexpr std::string_view name = "fourier";

  double frequency = 64;        ///< f, periods across the projector field
  bool pi_shift = false;        ///< a second frame, shifted by half a period
  std::optional<double> low{};  ///< f_l, periods of a second carrier in the same frames, below f
  Shifts shifts{};

  static void for_each_setting(auto& self, const auto& visit) {
    visit("frequency", "periods across the projector field", self.frequency);
    visit("pi_shift", "second frame, shifted by half a period, to remove the mean", self.pi_shift);
    visit("low", "low frequency, periods across the field", self.low);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;

  /// Extracts sine, cosine and mean of each carrier.
  [[nodiscard]] Demodulation demodulation() const;
  [[nodiscard]] double read_shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

/// One frame of several PMP patterns, each amplitude-modulating a carrier across the axis (Guan,
/// Hassebrook and Lau 2003), and a sinusoid of many periods along the axis, which measures (Yue, Su
/// and Liu 2007, Section 1.2): the only single-frame coding that gives a coordinate on its own. See
/// Demodulator.
struct CompositePattern {
  static constexpr std::string_view name = "composite";

  double high = 32;                          ///< f_h, periods of the measuring sinusoid
  double low = 1;                            ///< f_l, periods of the patterns on the carriers
  std::vector<double> carriers{24, 40, 56};  ///< periods across the axis, one per step (N)
  double share = 0.4;                        ///< share of the modulation for the high frequency

  static void for_each_setting(auto& self, const auto& visit) {
    visit("high", "high frequency, periods across the field", self.high);
    visit("low", "low frequency, periods across the field", self.low);
    visit("carriers", "periods across the axis, one per step", self.carriers);
    visit("share", "modulation share of the high frequency; the cue gets the rest", self.share);
  }

  void require_valid() const;
  [[nodiscard]] double shape(int n, double y, double across) const;

  /// Extracts the N patterns of the low frequency and sine, cosine and mean of the high one.
  [[nodiscard]] Demodulation demodulation() const;
  [[nodiscard]] double read_shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;

 private:
  [[nodiscard]] int steps() const { return static_cast<int>(carriers.size()); }
};

// Single-frame codings whose elements are identified by their neighbours. They are decoded as
// fringes: see located_by_neighbours.

/// Decodes it as frames of one period and of `periods`, whose noise matches one edge or symbol.
Demodulation read_as_fringes(int shown, double periods, SymbolGrid grid);

/// The layout of such frames.
Layout fringes_of(const Demodulation& grid);

/// Coloured stripes whose transitions are identified by their neighbours (after Zhang, Curless and
/// Seitz 2002): three frames, or one in colour.
struct DeBruijn {
  static constexpr std::string_view name = "de-bruijn";

  int stripes = 96;

  static void for_each_setting(auto& self, const auto& visit) {
    visit("stripes", "number of stripes across the projector field", self.stripes);
  }

  void require_valid() const {}  // checked by coloured_stripes

  /// With the slopes of half as many periods.
  [[nodiscard]] Demodulation demodulation() const {
    return read_as_fringes(3, stripes / 2.0, coloured_stripes(stripes));
  }
};

/// A grid of three symbols in which each square of three by three is unique (after Morano et al.
/// 1998; Albitar, Graebling and Doignon 2007).
struct SymbolArray {
  static constexpr std::string_view name = "m-array";

  int columns = 40, rows = 25;  ///< along and across the axis

  static void for_each_setting(auto& self, const auto& visit) {
    visit("columns", "number of symbols along the axis", self.columns);
    visit("rows", "number of symbols across the axis", self.rows);
  }

  void require_valid() const {}  // checked by symbol_array

  [[nodiscard]] Demodulation demodulation() const {
    return read_as_fringes(1, columns, symbol_array(columns, rows));
  }
};

}  // namespace slipstream
