#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "slipstream/image/image.h"

namespace slipstream {

/// A pixel of a surface, and its fringe order less that of all.
struct SurfacePixel {
  int column = 0, row = 0, order = 0;
};

/// What is to be added to all orders of a surface; none where that is not sure.
using SurfaceChoice = std::function<std::optional<int>(const std::vector<SurfacePixel>& surface)>;

/// The coordinate of a phase of many periods, surface by surface: pixels are on one surface where
/// the phase goes on from each to the next by less than a quarter of a period, and so their orders
/// are known to one whole number, which `choose` finds. NaN where `wrapped_phase` (rad, [0, 2 pi))
/// is, where a surface has less than 64 pixels and where none is chosen.
Image<double> coordinate_by_surfaces(const Image<double>& wrapped_phase, double periods,
                                     const SurfaceChoice& choose);

/// Fringe orders that a pixel may have, first to last; none where the first is beyond the last.
struct OrderRange {
  int first = 0, last = -1;
};

/// The order under which 99.5 % of the pixels have one that they may have, where under any other
/// one in a hundred less do. `possible` must outlive it.
SurfaceChoice by_possible_orders(const Image<OrderRange>& possible);

}  // namespace slipstream
