#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "slipstream/base/image.h"

namespace slipstream {

/// One cell of Tables 3.1, 3.2, 3.3 of Liu 2010: how many pixels are unwrapped rightly, in %.
struct UnwrappingCell {
  int steps = 3;  ///< N
  double alpha_p = 200;
  double high = 3;  ///< f_h
  double c1 = 0.5;
  double published = 0;   ///< as printed, %
  double recomputed = 0;  ///< by the published rule, %
  double improved = 0;    ///< by the default rule, %
  /// Pixels that the published rule unwraps rightly and the default rule does not.
  std::size_t worse = 0;
};

/// What the cells are computed from: noise of sigma_w^2 = 1.55 at alpha = 0.5, beta = -7, beta_p =
/// 255 - alpha_p, frames not quantised.
struct UnwrappingTrial {
  enum class Surface { smooth, stepped };
  Surface surface = Surface::smooth;  ///< `stepped` has depth edges
  Size size{640, 480};
  std::uint64_t seed = 1;
};

/// The nine cells of Table 3.1, 3.2 or 3.3, row by row, as printed and recomputed. `steps`: 3, 4 or
/// 5. Throws Error for another.
std::vector<UnwrappingCell> unwrapping_table(int steps, const UnwrappingTrial& trial = {});

/// Projector coordinate of a smooth surface: from one end of the field to the other down the rows.
Image<double> smooth_coordinate(Size size);

/// Projector coordinate of a slope with 24 discs, blocks and strips before it, each set off by
/// another amount, from a small part of a period to many and close to whole ones.
Image<double> stepped_coordinate(Size size);

}  // namespace slipstream
