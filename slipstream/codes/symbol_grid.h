#pragma once

#include <cstdint>
#include <vector>

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

}  // namespace slipstream
