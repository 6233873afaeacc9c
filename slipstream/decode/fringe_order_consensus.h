#pragma once

#include <cstdint>

#include "slipstream/base/image.h"

namespace slipstream {

/// When a fringe order is believed.
struct FringeOrderConsensus {
  /// Largest disagreement of low and high frequency, in periods of the higher, that needs no more
  /// than `fewest_neighbours`: see fringe_order_residual.
  double largest_doubt = 0.25;
  int fewest_neighbours = 1;   ///< of the 8, that agree with a pixel whose frequencies agree
  int fewest_if_doubtful = 3;  ///< of the 8, that agree with a pixel whose frequencies do not

  friend bool operator==(const FringeOrderConsensus&, const FringeOrderConsensus&) = default;
};

/// 1 where the fringe order must be taken for wrong: a lit pixel with too few lit neighbours that
/// agree with it. Neighbours agree whose coordinates differ by less than half a fringe, 1 / (2
/// frequency): a wrong order is a whole one away. A region off by the same order is not found.
/// `coordinate`: y; `doubt`: 0 to 0.5, of each pixel; `lit`: 1 where the modulation suffices.
Image<std::uint8_t> unconfirmed_fringe_orders(const Image<double>& coordinate,
                                              const Image<double>& doubt,
                                              const Image<std::uint8_t>& lit, double frequency,
                                              const FringeOrderConsensus& settings = {});

}  // namespace slipstream
