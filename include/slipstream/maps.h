#pragma once

#include <cstdint>
#include <string_view>

#include "slipstream/image.h"
#include "slipstream/setting.h"

namespace slipstream {

/// When a fringe order is accepted.
struct FringeOrderConsensus {
  /// Largest disagreement of low and high frequency, in periods of the higher one, for which
  /// `fewest_neighbours` is enough: see fringe_order_residual.
  double largest_doubt = 0.25;
  int fewest_neighbours = 1;   ///< of the 8 that must agree with a pixel up to largest_doubt
  int fewest_if_doubtful = 3;  ///< of the 8 that must agree with a pixel above it

  static void for_each_setting(auto& self, const auto& visit) {
    visit({.name = "largest_doubt",
           .help = "disagreement of the frequencies, periods, up to which `fewest_neighbours` is "
                   "enough"},
          self.largest_doubt);
    visit({.name = "fewest_neighbours",
           .help = "of the 8 that must agree on the fringe order up to `largest_doubt`"},
          self.fewest_neighbours);
    visit({.name = "fewest_if_doubtful", .help = "of the 8 that must agree above it"},
          self.fewest_if_doubtful);
  }

  friend bool operator==(const FringeOrderConsensus&, const FringeOrderConsensus&) = default;
};

/// How phase is computed in double. All but the last agree to 1e-12 rad; they differ in speed.
enum class PhaseMethod {
  equation,         ///< Eqs. (1.3)-(1.7), any weights, any pixel
  closed_form,      ///< Eqs. (2.1)-(2.3), (2.13)-(2.15), N = 3, 4, 6, any pixel
  tables,           ///< MLUT and PLUT, Eqs. (2.4)-(2.18), N = 3, 4, 6, 8-bit pixels
  intensity_ratio,  ///< IntensityRatio, N = 3, any pixel; to 2e-8 rad
};

/// "equation", "closed-form", "lut", "intensity-ratio".
std::string_view name_of(PhaseMethod method);

/// How to determine the fringe order from a cue in the same frames as the high frequency.
enum class CueRule {
  published,   ///< Liu 2010, Section 3.2: the order nearest to the cue's coordinate
  likelihood,  ///< the order with the greatest likelihood over all channels of the pixel
  consensus,   ///< the most likely order given the pixel and its neighbours on the same surface
};

/// "published", "likelihood", "consensus".
std::string_view name_of(CueRule rule);

/// Parses such a name; throws Error for any other.
CueRule cue_rule_named(std::string_view name);

/// Decoded values of every camera pixel of one scan, before triangulation. Pass them in again to
/// reuse their memory.
template <class Real>
struct BasicMaps {
  Image<Real> mean;           ///< A^c, grey levels of the frames
  Image<Real> modulation;     ///< B^c, grey levels; the least over several sinusoids
  Image<Real> wrapped_phase;  ///< of the highest frequency, rad, [0, 2 pi)
  /// Disagreement of the frequencies about the fringe order, in periods of the higher one: 0 to
  /// 0.5, see fringe_order_residual. Empty with a single frequency.
  Image<Real> fringe_order_doubt;
  /// Projector coordinate y, [0, 1) across the field; beyond its ends by up to half a pixel, for
  /// frequencies below 1 by half the unlit part, for PCMP by a tenth of a period (half by the
  /// published rule). Set at every pixel, lit or not; NaN where the depth range leaves the order
  /// ambiguous. May be empty.
  Image<Real> coordinate;
  /// With patterns along both axes: distance of the two coordinates from the pixel's epipolar line,
  /// projector pixels, signed; NaN where either was not measured. Otherwise empty.
  Image<Real> epipolar_distance{};
  /// For a window longer than a cycle: phase change per frame, rad; see MotionMeasurement.
  /// Otherwise empty.
  Image<Real> motion{};
  /// If points lit by other surfaces are rejected: the error of the coordinate that such light may
  /// cause, in standard deviations by noise; NaN without a point. Otherwise empty.
  Image<Real> reflection{};
  /// If contrast is corrected: the pull that was taken from each coordinate, fields; 0 at most
  /// pixels. Otherwise empty.
  Image<Real> contrast{};
};

/// For display and writing.
using Maps = BasicMaps<float>;

/// Converts the precision; reuses memory if the size matches.
template <class From, class To>
void convert(const BasicMaps<From>& from, BasicMaps<To>& to) {
  convert(from.mean, to.mean);
  convert(from.modulation, to.modulation);
  convert(from.wrapped_phase, to.wrapped_phase);
  convert(from.fringe_order_doubt, to.fringe_order_doubt);
  convert(from.coordinate, to.coordinate);
}

/// 1 where B^c (grey levels) is at least `minimum`; elsewhere the phase is meaningless.
Image<std::uint8_t> modulation_mask(const Image<double>& modulation, double minimum);

/// 1 where the fringe order counts as wrong: at lit pixels with too few lit neighbours within half
/// a fringe, 1 / (2 frequency), of y; it misses a region that is off by one order. `coordinate`: y;
/// `doubt`: 0 to 0.5; `lit`: 1 where the modulation suffices.
Image<std::uint8_t> unconfirmed_fringe_orders(const Image<double>& coordinate,
                                              const Image<double>& doubt,
                                              const Image<std::uint8_t>& lit, double frequency,
                                              const FringeOrderConsensus& settings = {});

}  // namespace slipstream
