#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/base/size.h"

namespace slipstream {

/// One cell of Tables 3.5 and 3.7 of Liu 2010: variance of y by PMP of unit frequency over that by
/// PCMP of as many steps, over the pixels that PCMP unwraps rightly.
struct VarianceRatioCell {
  int steps = 4;
  double high = 4;
  double c1 = 0.5;
  double published = 0;  ///< the dissertation's measurement, as printed
  double predicted = 0;  ///< c_1^2 f_h^2, Eqs. (3.40) and (3.63)
  double measured = 0;   ///< on a virtual scan of a board
  double of_foam = 0;    ///< the same with VarianceRatioTrial's gamma and translucency
};

/// What the cells are measured on: a board in view of the example scanner, alpha_p = 200, beta_p =
/// 55, beta = -7, sigma_w^2 = 1.55, 8 bits.
struct VarianceRatioTrial {
  Size camera{640, 480};
  std::uint64_t seed = 1;
  /// What (3.79) less (3.20) says of the dissertation's projector: a second harmonic of 1.4 %.
  double gamma = 1.04;
  double translucency = 4.5;  ///< mm in a white foam board, see Physics
};

/// The nine cells of Table 3.5 (`steps` 4) or 3.7 (5), row by row. Throws Error for other steps.
std::vector<VarianceRatioCell> variance_ratio_table(int steps,
                                                    const VarianceRatioTrial& trial = {});

}  // namespace slipstream
