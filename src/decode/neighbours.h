#pragma once

#include <vector>

#include "decode/located_pixels.h"
#include "slipstream/one_frame.h"
#include "slipstream/pattern_set.h"

namespace slipstream {

/// Locates pixels from the frames of a grid, see Demodulation. Rejects ambiguous ones.
LocatedPixels located_by_neighbours(const SymbolGrid& grid, Axis axis,
                                    std::vector<Image<float>> frames);

}  // namespace slipstream
