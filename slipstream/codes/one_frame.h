#pragma once

#include <cstdint>

#include "slipstream/codes/phase_shifting.h"

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

/// Successive transitions, and side of a square of symbols, that are unique.
inline constexpr int stripe_window = 4, symbol_window = 3;

/// A row of stripes, each of one or two of three channels (bits 1, 2 and 4), that shares a lit one
/// with the next; any stripe_window transitions are unique. Throws Error for other than 8 to 256.
SymbolGrid coloured_stripes(int stripes);
/// Symbols 0 to 2 of which each square, symbol_window a side, is unique. Throws Error for less than
/// 8 along a side or more than 4096.
SymbolGrid symbol_array(int columns, int rows);

/// 0: round, 1: long along the axis, 2: across it. Intensity in [0, 1] at a place of its cell, -0.5
/// to 0.5.
double symbol_shape(int symbol, double along, double across);
/// Intensity of the grid: stripes in channel n, with a sinusoid's slopes between their middles; or
/// symbols.
double grid_intensity(const SymbolGrid& grid, int n, double y, double across);

/// A frame taken out of the spectrum of frames that hold several things, each at its own carrier.
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
  /// If not empty, what is shown: stripes in three frames, symbols in one, which give pixels their
  /// places in the field, and all carriers their phases.
  SymbolGrid grid{};

  friend bool operator==(const Demodulation&, const Demodulation&) = default;
};

/// Sine, cosine and mean of a carrier along the axis, and their band from frame `first` on.
std::vector<SpectralFrame> sine_cosine_mean(double periods, double share = 1);
Band sine_cosine_mean_band(int frames, int first, double periods, const Shifts& shifts = {});
/// What would show frame n of these three: in [0, 1].
double sine_cosine_mean_shape(int n, double periods, double y, const Shifts& shifts = {});

/// Fourier transform profilometry: the phase of one frame of many periods, by their place in its
/// spectrum (Takeda and Mutoh 1983, Section 1.2); or of two, the second half a period on, which
/// removes the mean (Li et al. 1990). A second carrier gives each surface the order under which
/// both phases agree (Takeda et al. 1997). See Demodulator.
struct FourierProfilometry {
  static constexpr std::string_view name = "fourier";

  double frequency = 64;        ///< f, periods across the projector field
  bool pi_shift = false;        ///< a second frame, half a period on
  std::optional<double> low{};  ///< f_l, periods of a second carrier in the same frames, below f
  Shifts shifts{};

  static void for_each_setting(auto& self, const auto& visit) {
    visit("frequency", "periods across the projector field", self.frequency);
    visit("pi_shift", "a second frame half a period on, which takes the mean away", self.pi_shift);
    visit("low", "periods of the low frequency", self.low);
    visit_shifts(self.shifts, visit);
  }
  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;
  /// To sine, cosine and mean of each carrier.
  [[nodiscard]] Demodulation demodulation() const;
  [[nodiscard]] double read_shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

/// One frame that holds PMP patterns, each as the strength of a carrier across the axis (Guan,
/// Hassebrook and Lau 2003), and a sinusoid of many periods along it, which measures (Yue, Su and
/// Liu 2007, Section 1.2): the one single-frame coding that gives a coordinate by itself. See
/// Demodulator.
struct CompositePattern {
  static constexpr std::string_view name = "composite";

  double high = 32;                          ///< f_h, periods of the sinusoid that measures
  double low = 1;                            ///< f_l, of those that the carriers hold
  std::vector<double> carriers{24, 40, 56};  ///< periods across the axis, one for each of N steps
  double share = 0.4;                        ///< of the modulation for the high frequency

  static void for_each_setting(auto& self, const auto& visit) {
    visit("high", "high frequency, periods across the field", self.high);
    visit("low", "low frequency, periods across the field", self.low);
    visit("carriers", "periods across the axis, one for each step", self.carriers);
    visit("share", "of the modulation for the high frequency, the rest for the cue", self.share);
  }
  void require_valid() const;
  [[nodiscard]] double shape(int n, double y, double across) const;
  /// To the N patterns of the low frequency, and sine, cosine and mean of the high one.
  [[nodiscard]] Demodulation demodulation() const;
  [[nodiscard]] double read_shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;

 private:
  [[nodiscard]] int steps() const { return static_cast<int>(carriers.size()); }
};

// Codings of one frame whose parts are known by their neighbours. They are read as fringes: see
// located_by_neighbours.

/// As frames of one period, and of so many that noise is that of an edge or a symbol.
Demodulation read_as_fringes(int shown, double periods, SymbolGrid grid);
/// The layout of such frames.
Layout fringes_of(const Demodulation& grid);

/// Coloured stripes whose transitions are known by their neighbours (after Zhang, Curless and Seitz
/// 2002): three frames, or one in colour.
struct DeBruijn {
  static constexpr std::string_view name = "de-bruijn";

  int stripes = 96;

  static void for_each_setting(auto& self, const auto& visit) {
    visit("stripes", "across the projector field", self.stripes);
  }
  void require_valid() const {}  // the stripes are
  /// With the slopes that half as many periods have.
  [[nodiscard]] Demodulation demodulation() const {
    return read_as_fringes(3, stripes / 2.0, coloured_stripes(stripes));
  }
};

/// A grid of three symbols, each square of three by three of which comes once (after Morano et al.
/// 1998; Albitar, Graebling and Doignon 2007).
struct SymbolArray {
  static constexpr std::string_view name = "m-array";

  int columns = 40, rows = 25;  ///< along the axis, and across it

  static void for_each_setting(auto& self, const auto& visit) {
    visit("columns", "of symbols along the axis", self.columns);
    visit("rows", "of symbols across the axis", self.rows);
  }
  void require_valid() const {}  // the symbols are
  [[nodiscard]] Demodulation demodulation() const {
    return read_as_fringes(1, columns, symbol_array(columns, rows));
  }
};

}  // namespace slipstream
