#pragma once

#include "decode/located_pixels.h"
#include "slipstream/one_frame.h"

namespace slipstream {

/// Locates pixels from symbols: bright spots at the grid's pitch are neighbours, which give the
/// surface's slant and so each symbol. All squares of symbols vote for positions; pixels between
/// four spots that agree are interpolated.
LocatedPixels located_by_symbols(const SymbolGrid& grid, const Image<float>& picture);

}  // namespace slipstream
