#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "slipstream/codes/demodulation.h"
#include "slipstream/codes/layout.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {

/// Fourier transform profilometry: the phase of one frame of many periods, by where they stand in
/// its spectrum (Takeda and Mutoh 1983, Section 1.2), or of two, the second half a period on, whose
/// mean is then no part of it (Li et al. 1990). With a second carrier each surface has the order
/// under which both phases agree (Takeda et al. 1997). See Demodulator.
struct FourierProfilometry {
  static constexpr std::string_view name = "fourier";

  double frequency = 64;        ///< f, periods across the projector field
  bool pi_shift = false;        ///< a second frame, half a period on
  std::optional<double> low{};  ///< f_l, periods of a second carrier in the same frames, below f
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
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

/// One frame that holds the patterns of phase measuring, each as the strength of a carrier across
/// the axis (Guan, Hassebrook and Lau 2003), and with them a sinusoid of many periods along it,
/// which measures (Yue, Su and Liu 2007, Section 1.2): the one coding of one frame that gives a
/// projector coordinate by itself. See Demodulator.
struct CompositePattern {
  static constexpr std::string_view name = "composite";

  double high = 32;                          ///< f_h, periods of the sinusoid that measures
  double low = 1;                            ///< f_l, of those that the carriers hold
  std::vector<double> carriers{24, 40, 56};  ///< periods across the axis, one for each of N steps
  double share = 0.4;                        ///< of the modulation for the high frequency

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
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

/// Coloured stripes, each transition of which is known by those beside it (after Zhang, Curless and
/// Seitz 2002): three frames, which are one in colour.
struct DeBruijn {
  static constexpr std::string_view name = "de-bruijn";

  int stripes = 96;

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("stripes", "across the projector field", self.stripes);
  }
  void require_valid() const;
  [[nodiscard]] Demodulation demodulation() const;
  [[nodiscard]] Layout layout() const;
};

/// A grid of three symbols, each square of three by three of which comes once (after Morano et al.
/// 1998; Albitar, Graebling and Doignon 2007).
struct SymbolArray {
  static constexpr std::string_view name = "m-array";

  int columns = 40, rows = 25;  ///< along the axis, and across it

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("columns", "of symbols along the axis", self.columns);
    visit("rows", "of symbols across the axis", self.rows);
  }
  void require_valid() const;
  [[nodiscard]] Demodulation demodulation() const;
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
