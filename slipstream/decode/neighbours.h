#pragma once

#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/demodulation.h"
#include "slipstream/codes/pattern_set.h"

namespace slipstream {

/// Where pixels are in the projector's field.
struct LocatedPixels {
  explicit LocatedPixels(Size size);

  Image<float> coordinate;  ///< along the axis; NaN where it is not known
  Image<float> modulation;  ///< grey levels of the frames; 0 there
};

/// By the frames of a grid, see Demodulation. What is doubtful is left out.
LocatedPixels located_by_neighbours(const SymbolGrid& grid, Axis axis,
                                    std::vector<Image<float>> frames);

/// Of stripes down the columns, by three channels: where along each row a channel rises or falls
/// against the strongest is a transition; all of a row together are matched to those shown by
/// dynamic programming, after Zhang, Curless and Seitz 2002, in which the order may break at a
/// price. One that could be another at little more, or that no row beside it has, is none; pixels
/// between one and the next are between their places.
LocatedPixels located_by_stripes(const SymbolGrid& grid, const std::vector<Image<float>>& channels);

/// Of symbols: bright spots about where a grid's next ones should be are neighbours, which say how
/// the surface leans, and so what each symbol is. All squares of symbols that are shown vote for
/// places; pixels between four that agree are between their places.
LocatedPixels located_by_symbols(const SymbolGrid& grid, const Image<float>& picture);

}  // namespace slipstream
