#pragma once

#include <string_view>
#include <vector>

#include "slipstream/codes/layout.h"

namespace slipstream {

/// A whole-numbered sum of the bands' phases: it has the same sum of their periods. A band itself
/// is one, the beat of two bands, their difference, another.
struct PhaseSum {
  std::vector<int> of{};  ///< a factor for each band
  double periods = 1;
};

/// How far away a wrong fringe order is.
struct WrongOrder {
  /// What noise must reach, in its standard deviations where alpha alpha_p / 2 and sigma_w are 1:
  /// in proportion to their ratio.
  double margin = 0;
  double count = 0;  ///< of orders so far away: as seen from a pixel, on average over the field
};

/// By what the fringe order of a pixel is found.
enum class OrderSource {
  bands,       ///< by the pixel's bands, each by the one of fewer periods before it
  pixel,       ///< by all that the pixel's frames say together
  neighbours,  ///< by a cue in the frames of the measuring band, and by the pixels beside it
  surface,     ///< by all pixels of a connected surface, which have one order
};

/// What a way of unwrapping says of itself, so that all else need not know which one it is. A new
/// way is a value of Unwrapping, its line in unwrapping.cpp and what it does to a pixel, in
/// decode/.
struct UnwrappingWay {
  std::string_view name;
  OrderSource order_source;
  bool weighs_bands = false;   ///< all bands have a part in the coordinate, see band_weights
  bool reads_code = false;     ///< the stripes of Layout::code say the order
  bool whole_stripes = false;  ///< the coordinate is a stripe's middle, whatever the noise
  bool in_kernels = true;      ///< the engines in float have it; else the reference engine alone
  /// Throws Error, beginning with `name`, unless the layout has what this way needs; null: nothing.
  void (*require)(const Layout& layout, std::string_view name) = nullptr;
  /// See unwrapping_chain; null: the measuring band alone.
  std::vector<PhaseSum> (*chain)(const Layout& layout) = nullptr;
  double (*least_periods)(const Layout& layout) = nullptr;  ///< null: 1
  /// See the function of that name; null: by the steps of the chain.
  std::vector<WrongOrder> (*wrong_orders)(const Layout& layout) = nullptr;
};

const UnwrappingWay& way_of(Unwrapping unwrapping);
OrderSource order_source(const Layout& layout);

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

/// Each step of the chain has one order before the right one and one behind it; with
/// Unwrapping::likelihood each whole number of periods of the measuring band is one way. Empty
/// where nothing is unwrapped, or not by bands.
std::vector<WrongOrder> wrong_orders(const Layout& layout);
/// The nearest of them; infinite where there is none.
double unwrapping_margin(const Layout& layout);

}  // namespace slipstream
