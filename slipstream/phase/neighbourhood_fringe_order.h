#pragma once

#include <cstdint>
#include <functional>

#include "slipstream/image/image.h"

namespace slipstream {

/// What speaks against `order` at a pixel: minus twice the logarithm of its likelihood, up to a
/// constant of the pixel. Infinite where the order is impossible.
using FringeOrderCost = std::function<double(int column, int row, int order)>;

/// Which neighbours are asked, and how much they count.
struct NeighbourhoodChoice {
  int radius = 2;              ///< of the square window around the pixel, 1 or 2
  double steepest = 0.25;      ///< periods per pixel; a step of the phase above it is an edge
  double roughest = 0.05;      ///< periods; what a step may differ from those before and after it
  double most_evidence = 4;    ///< a neighbour's evidence counts no more than this
  double disagreement = 0.25;  ///< cost of a neighbour that chose otherwise
  /// So many of the eight neighbours that hold in the end what the pixel said alone show an edge
  /// that the wrapped phase does not, one of whole periods: there the pixel's own choice stands.
  int hidden_edge = 1;
  int passes = 3;
};

/// Chooses the fringe orders once more, each from the evidence of its pixel and of the neighbours
/// on the same surface: those that can be reached through the window without crossing an edge of
/// the wrapped phase, where the order that a choice here implies there is known. Across an edge
/// nothing is said. `wrapped_phase`: rad, [0, 2 pi); `orders`: the pixels' own choices, and then
/// the result; `lit`: 1 where the phase means something.
void choose_with_neighbours(Image<int>& orders, const Image<double>& wrapped_phase,
                            const Image<std::uint8_t>& lit, const FringeOrderCost& cost,
                            const NeighbourhoodChoice& settings = {});

}  // namespace slipstream
