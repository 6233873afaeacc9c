#pragma once

#include <cstdint>
#include <functional>

#include "slipstream/base/image.h"
#include "slipstream/decode/neighbourhood_vote.h"

namespace slipstream {

/// What speaks against `order` at a pixel: minus twice the logarithm of its likelihood, up to a
/// constant of the pixel. Infinite where the order is impossible.
using FringeOrderCost = std::function<double(int column, int row, int order)>;

/// Chooses the fringe orders once more, each from the evidence of its pixel and of the neighbours
/// on the same surface: those that can be reached through the window without crossing an edge of
/// the wrapped phase, where the order that a choice here implies there is known. Across an edge
/// nothing is said. `wrapped_phase`: rad, [0, 2 pi); `orders`: the pixels' own choices, and then
/// the result; `lit`: 1 where the phase means something.
void choose_with_neighbours(Image<int>& orders, const Image<double>& wrapped_phase,
                            const Image<std::uint8_t>& lit, const FringeOrderCost& cost);

}  // namespace slipstream
