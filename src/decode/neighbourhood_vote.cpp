#include "decode/neighbourhood_vote.h"

#include "base/numbers.h"
#include "decode/cue_evidence.h"
#include "decode/decoder.h"
#include "decode/phase_decoder.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Full images as the Field of a NeighbourhoodVote.
class ImageField {
 public:
  ImageField(const Image<int>& own, const Image<double>& wrapped_phase,
             const Image<std::uint8_t>& lit, const FringeOrderCost& cost)
      : own_(own), phase_(wrapped_phase), lit_(lit), cost_(cost), shift_(own.size()) {}

  [[nodiscard]] double periods(int column, int row) const {
    if (!inside(column, row) || lit_(column, row) == 0) return nan;
    return phase_(column, row) / two_pi + own_(column, row);
  }

  void periods_around(int column, int row, PhaseWindow& window) const {
    for_each_pixel_in_order({9, 9}, [&](int c, int r) {
      window.periods[r * PhaseWindow::line + c] =
          static_cast<float>(periods(column + c - 4, row + r - 4) - periods(column, row));
    });
  }

  static void foresee(const std::vector<PixelPlace>&) {}

  [[nodiscard]] double against(PixelPlace at, int shift) const {
    const int own = own_(at.column, at.row);
    return cost_(at.column, at.row, own + shift) - cost_(at.column, at.row, own);
  }

  [[nodiscard]] static bool own_order_costs_least() { return false; }

  [[nodiscard]] int shift(PixelPlace at) const {
    return inside(at.column, at.row) ? shift_(at.column, at.row) : 0;
  }

  void set_shift(PixelPlace at, int shift) { shift_(at.column, at.row) = shift; }

 private:
  [[nodiscard]] bool inside(int column, int row) const {
    return column >= 0 && row >= 0 && column < lit_.width() && row < lit_.height();
  }

  const Image<int>& own_;
  const Image<double>& phase_;
  const Image<std::uint8_t>& lit_;
  const FringeOrderCost& cost_;
  Image<int> shift_;
};

Image<CuePixel> cue_pixels(const LayoutPhases& phases, double grey_level) {
  const PhaseMaps& band = phases.bands.front();
  Image<CuePixel> pixels(band.modulation.size());

  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    pixels.begin()[i] = {
        .modulation = band.modulation.begin()[i] / grey_level,
        .wrapped_phase = band.wrapped_phase.begin()[i],
        .cue = phases.cue.begin()[i] / grey_level,
        .cue_sine = phases.cue_sine.empty() ? 0 : phases.cue_sine.begin()[i] / grey_level};
  }

  return pixels;
}

/// The fringe order of every pixel by the given rule.
Image<int> chosen_orders(const Image<CuePixel>& pixels, const Image<double>& wrapped_phase,
                         const CueEvidence& cue, CueRule rule, double f_h, int projector_length) {
  Image<int> orders(pixels.size());

  // 1. Each pixel by itself.
  std::ranges::transform(pixels, orders.begin(), [&](const CuePixel& pixel) {
    switch (rule) {
      case CueRule::published:
        return cue.published_order(pixel);
      case CueRule::likelihood:
        return cue.likeliest_order(pixel, projector_length);
      case CueRule::consensus:
        return cue.nearest_order(pixel, projector_length);
    }
    return 0;
  });

  // 2. With its neighbours: lit pixels vote, orders beyond the field are impossible.
  if (rule != CueRule::consensus) return orders;
  Image<std::uint8_t> lit(pixels.size());
  std::ranges::transform(pixels, lit.begin(), [&](const CuePixel& pixel) {
    return static_cast<std::uint8_t>(cue.lit(pixel) ? 1 : 0);
  });

  const auto cost = [&](int column, int row, int order) {
    const CuePixel& pixel = pixels(column, row);
    const double y = unwrapped_coordinate(pixel.wrapped_phase, order, f_h);
    return cue.near_field(y, projector_length) ? cue.cost(pixel, y)
                                               : std::numeric_limits<double>::infinity();
  };

  choose_with_neighbours(orders, wrapped_phase, lit, cost);
  return orders;
}

}  // namespace

void choose_with_neighbours(Image<int>& orders, const Image<double>& wrapped_phase,
                            const Image<std::uint8_t>& lit, const FringeOrderCost& cost) {
  ImageField field(orders, wrapped_phase, lit, cost);
  NeighbourhoodVote vote(field);

  // Open pixels, in parallel; then as a list, in order.
  Image<std::uint8_t> open(orders.size());
  for_each_pixel(open.size(), [&](int column, int row) {
    open(column, row) = vote.disagrees({row, column}) ? 1 : 0;
  });

  NeighbourhoodVoteLists lists;
  for_each_pixel_in_order(orders.size(), [&](int column, int row) {
    if (open(column, row) != 0) lists.open.push_back({row, column});
  });

  vote(lists);
  for (const PixelPlace at : lists.ever_moved) orders(at.column, at.row) += field.shift(at);
}

UnwrappedPhases unwrap_by_vote(const Layout& layout, const LayoutPhases& phases,
                               const CueSettings& settings, int projector_length,
                               double grey_level) {
  const CueEvidence cue(layout, settings);
  const double f_h = layout.bands.front().periods;

  const Image<CuePixel> pixels = cue_pixels(phases, grey_level);
  const Image<int> orders = chosen_orders(pixels, phases.bands.front().wrapped_phase, cue,
                                          settings.rule, f_h, projector_length);

  // The published rule leaves the DC channel's cue in the texture.
  const bool shaded = needs_ambient_light(layout) && settings.rule != CueRule::published;

  const Size size = pixels.size();
  UnwrappedPhases result{.coordinate = Image<double>(size),
                         .doubt = Image<double>(size),
                         .shade = Image<double>(shaded ? size : Size{})};

  for_each_pixel(size, [&](int column, int row) {
    const CuePixel& pixel = pixels(column, row);
    const double y = unwrapped_coordinate(pixel.wrapped_phase, orders(column, row), f_h);

    result.coordinate(column, row) = y;
    result.doubt(column, row) = cue.doubt(pixel, y);
    if (shaded) result.shade(column, row) = grey_level * cue.shade(pixel, y);
  });

  return result;
}

}  // namespace slipstream
