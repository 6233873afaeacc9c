#include "slipstream/codes/neighbour_codes.h"

#include <utility>

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
