#pragma once

#include <algorithm>

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
  /// Noise, in standard deviations, that makes the order wrong where alpha alpha_p / 2 = sigma_w =
  /// 1; in proportion to their ratio.
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

/// What the frames say of one pixel.
struct PixelReading {
  std::span<const double> phases;  ///< of all bands, rad, [0, 2 pi)
  std::span<const double> modulations;
  /// Of all frames, grey levels, with a code, single frames or a way of one's own; else what there
  /// is.
  std::span<const double> intensities;
};

struct PixelCoordinate {
  double y = 0;         ///< see BasicMaps
  double doubt = 0;     ///< the most of all steps, see fringe_order_residual; of a code beyond what
                        ///< its stripes leave open; of single frames half of the least misfit over
                        ///< that of the next order
  double contrast = 0;  ///< with Unwrapping::code_alone: see CodeReading
};

/// What a way of unwrapping says of itself, so that all else need not know which one it is. One of
/// one's own is such a constant with a `pixel`, in any program: Layout::unwrapping takes it.
struct UnwrappingWay {
  std::string_view name;
  OrderSource order_source;
  bool weighs_bands = false;   ///< all bands have a part in the coordinate, see band_weights
  bool reads_code = false;     ///< the stripes of Layout::code say the order
  bool whole_stripes = false;  ///< the coordinate is a stripe's middle, whatever the noise
  /// Every order of the measuring band is tried: against all bands, or all single frames.
  bool tries_orders = false;
  bool in_kernels = true;        ///< the engines in float have it; else the reference engine alone
  bool gives_coordinate = true;  ///< of any number of periods; else of at most one
  /// Throws Error, beginning with `name`, unless the layout has what this way needs; null: nothing.
  void (*require)(const Layout& layout, std::string_view name) = nullptr;
  /// See unwrapping_chain; null: the measuring band alone.
  std::vector<PhaseSum> (*chain)(const Layout& layout) = nullptr;
  double (*least_periods)(const Layout& layout) = nullptr;  ///< null: 1
  /// See the function of that name; null: by the steps of the chain.
  std::vector<WrongOrder> (*wrong_orders)(const Layout& layout) = nullptr;
  /// Variance of y where sigma_w and B are 1, on average over the field; null: by band_weights.
  double (*coordinate_variance)(const Layout& layout) = nullptr;
  /// Of a way of one's own: what tells the coordinate of each pixel, on a projector of so many
  /// pixels along the axis. Its OrderSource is `pixel`, and the kernels do not have it.
  std::function<PixelCoordinate(const PixelReading&)> (*pixel)(const Layout& layout,
                                                               int projector_length) = nullptr;
};

inline OrderSource order_source(const Layout& layout) {
  return layout.unwrapping->order_source;
}

/// What is unwrapped in turn, from few periods to many, the measuring band last: the bands, or with
/// Unwrapping::beats the sums of them that noise disturbs least, the first of at most one period.
/// With other unwrappings the measuring band alone.
std::vector<PhaseSum> unwrapping_chain(const Layout& layout);
/// Whether the coordinate repeats beyond the field as the first of the chain does, so that both
/// ends of the field meet: all have whole multiples of its periods.
bool is_circle(const Layout& layout);
/// Weights of the bands' coordinates, which add up to 1: with Unwrapping::beats and likelihood
/// their inverse variances (0 below a hundredth of the best); else the measuring band alone.
std::vector<double> band_weights(const Layout& layout);

/// The fewest periods that unwrapping begins with: the coordinate is known up to whole multiples of
/// its inverse where is_circle.
double least_periods(const Layout& layout);

/// How far, in periods, a phase may rightly be from its stripe's middle: half a stripe, less where
/// a stripe is a whole period and nothing confirms the order at its ends.
constexpr double open_by_code(const Code& code, double periods) {
  return std::min(periods / (2 * code.stripes), 0.4);
}

/// One order before and one behind in each step of the chain; with Unwrapping::likelihood at each
/// whole number of periods. Empty where nothing is unwrapped by bands.
std::vector<WrongOrder> wrong_orders(const Layout& layout);
/// The nearest of them; infinite where there is none.
double unwrapping_margin(const Layout& layout);

}  // namespace slipstream
