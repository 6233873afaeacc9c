#pragma once

#include <vector>

#include "slipstream/codes/layout.h"

namespace slipstream {

/// A whole-numbered sum of the bands' phases: it has the same sum of their periods. A band itself
/// is one, the beat of two bands, their difference, another.
struct PhaseSum {
  std::vector<int> of{};  ///< a factor for each band
  double periods = 1;
};

/// What is unwrapped by what was before it, from few periods to many, the measuring band last: the
/// bands themselves, or with Unwrapping::beats those sums of them by whose noise the fringe orders
/// are least likely to go wrong, the first of at most one period. With other unwrappings the
/// measuring band alone.
std::vector<PhaseSum> unwrapping_chain(const Layout& layout);
/// Whether the coordinate repeats beyond the field as the first of the chain does, so that both
/// ends of the field meet: all have whole multiples of its periods.
bool is_circle(const Layout& layout);
/// Weights of the bands' coordinates in that of the layout, which add up to 1: with
/// Unwrapping::beats and likelihood the inverse of their variances (a band of less than a hundredth
/// of the best has none); else the measuring band's alone.
std::vector<double> band_weights(const Layout& layout);

/// The fewest periods that unwrapping begins with: the coordinate is known up to whole multiples of
/// its inverse where is_circle.
double least_periods(const Layout& layout);

/// How far, in periods, a phase rightly lies from the middle of its stripe: half a stripe. Where a
/// stripe is a whole period nothing confirms the order next to its ends; the doubt begins before.
double open_by_code(const Code& code, double periods);

/// A way for the fringe order to go wrong.
struct WrongOrder {
  /// What noise must reach, in its standard deviations where alpha alpha_p / 2 and sigma_w are 1:
  /// in proportion to their ratio.
  double margin = 0;
  double count = 0;  ///< of orders so far away: as seen from a pixel, on average over the field
};

/// Each step of the chain has one order before the right one and one behind it; with
/// Unwrapping::likelihood each whole number of periods of the measuring band is one way. Empty
/// where nothing is unwrapped, or not by bands.
std::vector<WrongOrder> wrong_orders(const Layout& layout);
/// The nearest of them; infinite where there is none.
double unwrapping_margin(const Layout& layout);

}  // namespace slipstream
