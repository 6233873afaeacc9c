#pragma once

#include <algorithm>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "slipstream/layout.h"

namespace slipstream {

/// An integer combination of the bands' phases; the same combination of their periods is its period
/// count. A single band is one, the beat (difference) of two bands another.
struct PhaseSum {
  std::vector<int> of{};  ///< a factor per band
  double periods = 1;
};

/// A wrong fringe order and how far away it is.
struct WrongOrder {
  /// Noise, in standard deviations, that causes it for alpha alpha_p / 2 = sigma_w = 1;
  /// proportional to their ratio.
  double margin = 0;
  double count = 0;  ///< number of orders at that distance from a pixel, on average over the field
};

/// How a pixel's fringe order is determined.
enum class OrderSource {
  bands,       ///< by the pixel's bands, each from the next coarser one
  pixel,       ///< by all of the pixel's frames together
  neighbours,  ///< by a cue in the frames of the measuring band, and by neighbouring pixels
  surface,     ///< by all pixels of a connected surface, which share one order
};

/// Values of one pixel in the frames.
struct PixelReading {
  std::span<const double> phases;  ///< of all bands, rad, [0, 2 pi)
  std::span<const double> modulations;
  /// Grey levels of all frames, with a code, single frames or a custom method; otherwise
  /// unspecified.
  std::span<const double> intensities;
};

struct PixelCoordinate {
  double y = 0;         ///< see BasicMaps
  double doubt = 0;     ///< largest residual of all steps, see fringe_order_residual; for a code
                        ///< beyond its stripe width; for a code alone half the stripes that its
                        ///< doubtful bits allow, of 4 to a period; for single frames half of the
                        ///< least misfit over the next order's
  double contrast = 0;  ///< with Unwrapping::code_alone: see CodeReading
};

/// The properties of an unwrapping method, so that other code need not know which one it is. A
/// custom method is such a constant with a `pixel`: set Layout::unwrapping to it.
struct UnwrappingWay {
  std::string_view name;
  OrderSource order_source;
  bool weighs_bands = false;   ///< all bands contribute to the coordinate, see band_weights
  bool reads_code = false;     ///< the stripes of Layout::code give the order
  bool whole_stripes = false;  ///< the coordinate is a stripe's centre, whatever the noise
  /// Every order of the measuring band is tried: against all bands, or all single frames.
  bool tries_orders = false;
  bool gives_coordinate = true;  ///< for any number of periods; otherwise for at most one

  /// Throws Error, beginning with `name`, unless the layout meets this method's needs; may be null.
  void (*require)(const Layout& layout, std::string_view name) = nullptr;
  /// See unwrapping_chain; null: the measuring band alone.
  std::vector<PhaseSum> (*chain)(const Layout& layout) = nullptr;
  double (*least_periods)(const Layout& layout) = nullptr;  ///< null: 1
  /// See the function wrong_orders; null: from the steps of the chain.
  std::vector<WrongOrder> (*wrong_orders)(const Layout& layout) = nullptr;
  /// Mean variance of y over the field for sigma_w = B = 1; null: from band_weights.
  double (*coordinate_variance)(const Layout& layout) = nullptr;
  /// For a custom method: returns a function that gives each pixel's coordinate, for a projector
  /// with that many pixels along the axis. Requires OrderSource `pixel`; not in the kernels.
  std::function<PixelCoordinate(const PixelReading&)> (*pixel)(const Layout& layout,
                                                               int projector_length) = nullptr;
};

inline OrderSource order_source(const Layout& layout) {
  return layout.unwrapping->order_source;
}

/// The combinations unwrapped in turn, from fewest periods to most, the measuring band last: the
/// bands or, with Unwrapping::beats, the combinations least sensitive to noise, the first of at
/// most one period. With other methods the measuring band alone.
std::vector<PhaseSum> unwrapping_chain(const Layout& layout);

/// Whether the coordinate is cyclic beyond the field with the period of the chain's first member,
/// so that both ends of the field meet: all have whole multiples of its periods.
bool is_circle(const Layout& layout);

/// Weights of the bands' coordinates, which sum to 1: with Unwrapping::beats and likelihood their
/// inverse variances (0 below a hundredth of the best); otherwise the measuring band alone.
std::vector<double> band_weights(const Layout& layout);

/// The frames of the first band, which must be a run of steps, as single ones, then the others.
std::vector<SingleFrame> frames_of_sinusoids(const Layout& layout);

/// The fewest periods at which unwrapping starts: the coordinate is known up to whole multiples of
/// its inverse if is_circle.
double least_periods(const Layout& layout);

/// How far, in periods, a phase may be from its stripe's centre: half a stripe, less if a stripe is
/// a whole period and nothing confirms the order at its ends.
constexpr double open_by_code(const Code& code, double periods) {
  return std::min(periods / (2 * code.stripes), 0.4);
}

/// One order before and one after in each step of the chain; with Unwrapping::likelihood one for
/// each whole number of periods. Empty unless bands unwrap.
std::vector<WrongOrder> wrong_orders(const Layout& layout);

/// Margin of the nearest wrong order; infinite if there is none.
double unwrapping_margin(const Layout& layout);

/// Fringe order k, Liu 2010, Eq. (1.17): the periods to add to `wrapped_phase` (rad, [0, 2 pi),
/// `frequency` periods across the field) to come nearest to `coarse_coordinate`, the coordinate
/// from a lower frequency. Not limited to the field: see coordinate_in_field.
int fringe_order(double wrapped_phase, double frequency, double coarse_coordinate);

/// Distance, in periods of `frequency`, of the coarse coordinate from the one with this fringe
/// order: [-0.5, 0.5], near 0 if the frequencies agree; at either end another order is as likely.
double fringe_order_residual(double wrapped_phase, double frequency, double coarse_coordinate,
                             int fringe_order);

/// Projector coordinate (phi + 2 pi k) / (2 pi f), Eqs. (1.8) and (1.17).
double unwrapped_coordinate(double wrapped_phase, int fringe_order, double frequency);

/// Brings a coordinate known up to whole multiples of `period` (>= 1, in fields) into the field:
/// -0.5 / projector_length to 1 - 0.5 / projector_length, as pixel centres are at integers. The
/// circle is cut in the middle of its unlit part, so that noise at one end of the field stays at
/// that end, up to half a pixel and half the unlit part.
double coordinate_in_field(double coordinate, double period, int projector_length);

}  // namespace slipstream
