#pragma once

#include <cstdint>

#include "slipstream/base/image.h"
#include "slipstream/base/setting.h"

namespace slipstream {

/// What the frames of one scan say about every camera pixel, before geometry. Kept and handed in
/// again it is written anew without allocation.
template <class Real>
struct BasicMaps {
  Image<Real> mean;           ///< A^c, grey levels of the frames
  Image<Real> modulation;     ///< B^c, likewise; the least where several sinusoids were shown
  Image<Real> wrapped_phase;  ///< of the highest frequency, rad, [0, 2 pi)
  /// How far apart the frequencies are on the fringe order, in periods of the higher one: 0 to 0.5,
  /// see fringe_order_residual. Empty when only one frequency was shown.
  Image<Real> fringe_order_doubt;
  /// Projector coordinate y, [0, 1) across the field; past its ends by half a pixel, for
  /// frequencies below 1 by half the unlit part, for PCMP by a tenth of a period (half by the
  /// published rule). At every pixel, lit or not; NaN where the range of depth leaves the order
  /// open. Empty if there is none.
  Image<Real> coordinate;
  /// Where patterns were shown along both axes: how far the two coordinates lie from the pixel's
  /// epipolar line, projector pixels, signed; NaN where either was not measured. Else empty.
  Image<Real> epipolar_distance{};
  /// Of a window over more than a cycle: phase change a frame, rad; see MotionMeasurement. Else
  /// empty.
  Image<Real> motion{};
};

/// What is shown and written.
using Maps = BasicMaps<float>;

/// From one precision to the other; memory is used where it is of the size.
template <class From, class To>
void convert(const BasicMaps<From>& from, BasicMaps<To>& to) {
  convert(from.mean, to.mean);
  convert(from.modulation, to.modulation);
  convert(from.wrapped_phase, to.wrapped_phase);
  convert(from.fringe_order_doubt, to.fringe_order_doubt);
  convert(from.coordinate, to.coordinate);
}

/// 1 where B^c (grey levels) is at least `minimum`; elsewhere the phase means nothing.
Image<std::uint8_t> modulation_mask(const Image<double>& modulation, double minimum);

/// When a fringe order is believed.
struct FringeOrderConsensus {
  /// Largest disagreement of low and high frequency, in periods of the higher, that needs no more
  /// than `fewest_neighbours`: see fringe_order_residual.
  double largest_doubt = 0.25;
  int fewest_neighbours = 1;   ///< of the 8, that agree with a pixel whose frequencies agree
  int fewest_if_doubtful = 3;  ///< of the 8, that agree with a pixel whose frequencies do not

  static void for_each_setting(auto& self, const auto& visit) {
    visit({.name = "largest_doubt"}, self.largest_doubt);
    visit({.name = "fewest_neighbours"}, self.fewest_neighbours);
    visit({.name = "fewest_if_doubtful"}, self.fewest_if_doubtful);
  }

  friend bool operator==(const FringeOrderConsensus&, const FringeOrderConsensus&) = default;
};

/// 1 where the fringe order counts as wrong: at lit pixels with too few lit neighbours within half
/// a fringe, 1 / (2 frequency), of y; a region off by one order is not found. `coordinate`: y;
/// `doubt`: 0 to 0.5; `lit`: 1 where the modulation suffices.
Image<std::uint8_t> unconfirmed_fringe_orders(const Image<double>& coordinate,
                                              const Image<double>& doubt,
                                              const Image<std::uint8_t>& lit, double frequency,
                                              const FringeOrderConsensus& settings = {});

}  // namespace slipstream
