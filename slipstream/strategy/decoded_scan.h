#pragma once

#include "slipstream/image/image.h"

namespace slipstream {

/// What the frames of one scan say about every camera pixel, before geometry.
struct DecodedScan {
  Image<double> mean;           ///< A^c, grey levels
  Image<double> modulation;     ///< B^c, grey levels; the least where several sinusoids were shown
  Image<double> wrapped_phase;  ///< of the highest frequency, rad, [0, 2 pi)
  /// How far apart the frequencies are on the fringe order, in periods of the higher one: 0 to 0.5,
  /// see fringe_order_residual. Empty when only one frequency was shown.
  Image<double> fringe_order_doubt;
  /// Projector coordinate y, [0, 1) across the field; past its ends by half a pixel, for
  /// frequencies below 1 by half of what is not lit, for PCMP by a tenth of a period (half of one
  /// by the published rule). A value stands at every pixel, lit or not: the modulation tells. Empty
  /// when the strategy has none.
  Image<double> coordinate;
};

}  // namespace slipstream
