#pragma once

#include <string_view>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/spectral_frame.h"

// Codings of one frame whose parts are known by their neighbours. They are read as fringes: see
// located_by_neighbours.
namespace slipstream {

/// Coloured stripes, each transition of which is known by those beside it (after Zhang, Curless and
/// Seitz 2002): three frames, which are one in colour.
struct DeBruijn {
  static constexpr std::string_view name = "de-bruijn";

  int stripes = 96;

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("stripes", "across the projector field", self.stripes);
  }

  /// Throws Error for settings outside their ranges.
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

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  [[nodiscard]] Demodulation demodulation() const;
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
