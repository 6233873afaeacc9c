#pragma once

#include <vector>

#include "decode/located_pixels.h"
#include "slipstream/one_frame.h"
#include "slipstream/pattern_set.h"

namespace slipstream {

/// Locates pixels from the frames of a grid, see Demodulation. Rejects ambiguous ones.
LocatedPixels located_by_neighbours(const SymbolGrid& grid, Axis axis,
                                    std::vector<Image<float>> frames);

/// Locates pixels from vertical stripes in three channels. A transition is where a channel rises or
/// falls relative to the strongest along a row; dynamic programming matches each row's transitions
/// to the displayed ones (after Zhang, Curless and Seitz 2002), where a break in the order has a
/// cost. Drops transitions that are ambiguous or absent from the adjacent rows, and interpolates
/// pixels between neighbouring ones.
LocatedPixels located_by_stripes(const SymbolGrid& grid, const std::vector<Image<float>>& channels);

}  // namespace slipstream
