#include "slipstream/decode/unwrap.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

#include "slipstream/base/converted.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/decode/band_unwrapper.h"
#include "slipstream/decode/cue_evidence.h"
#include "slipstream/decode/neighbourhood_fringe_order.h"
#include "slipstream/decode/surface_by_frames.h"
#include "slipstream/decode/surface_orders.h"
#include "slipstream/decode/temporal_unwrapping.h"

namespace slipstream {
namespace {

/// Calls `body(column, row)` for every pixel.
template <class Body>
void for_each_pixel(Size size, const Body& body) {
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) body(column, row);
  });
}

UnwrappedPhases unwrap_alone(const Layout& layout, const LayoutPhases& phases,
                             int projector_length) {
  const BandUnwrapper unwrapped(layout, projector_length);
  const Size size = phases.bands.front().wrapped_phase.size();
  UnwrappedPhases result{.coordinate = Image<double>(size)};
  if (unwrapped.can_doubt()) result.doubt = Image<double>(size);
  const std::size_t bands = phases.bands.size();
  if (layout.unwrapping == Unwrapping::code_alone) result.contrast = Image<double>(size);
  phases.frames.visit([&](const auto& frames) {
    for_each_row(size.height, [&](int row) {
      std::vector<double> phase(bands), modulation(bands), I(frames.size());
      for (int column = 0; column < size.width; ++column) {
        for (std::size_t i = 0; i < bands; ++i) {
          phase[i] = phases.bands[i].wrapped_phase(column, row);
          modulation[i] = phases.bands[i].modulation(column, row);
        }
        for (std::size_t n = 0; n < I.size(); ++n) I[n] = frames[n](column, row);
        const auto [y, doubt, contrast] = unwrapped({phase, modulation, I});
        result.coordinate(column, row) = y;
        if (!result.doubt.empty()) result.doubt(column, row) = doubt;
        if (!result.contrast.empty()) result.contrast(column, row) = contrast;
      }
    });
  });
  return result;
}

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

UnwrappedPhases unwrap_by_surfaces(const Layout& layout, const LayoutPhases& phases,
                                   double least_modulation) {
  const PhaseMaps& band = phases.bands.front();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Size size = band.wrapped_phase.size();
  Image<float> phase(size);
  std::transform(
      band.wrapped_phase.begin(), band.wrapped_phase.end(), band.modulation.begin(), phase.begin(),
      [&](double phi, double B) { return static_cast<float>(B > least_modulation ? phi : nan); });
  const double periods = layout.bands.front().periods;
  SecondPhase second;
  const bool two = layout.bands.size() == 2;
  if (two) {
    second.ratio = static_cast<float>(layout.bands[1].periods / periods);
    convert(phases.bands[1].wrapped_phase, second.wrapped);
  }
  SurfaceOrders by_surfaces;
  const Image<int>& orders =
      by_surfaces(phase, order_by_frames(layout, phases), two ? &second : nullptr);
  UnwrappedPhases result{.coordinate = Image<double>(size, nan), .doubt = Image<double>(size, 0.5)};
  for_each_pixel(size, [&](int column, int row) {
    const int order = orders(column, row);
    if (order == SurfaceOrders::none) return;
    const double y = unwrapped_coordinate(band.wrapped_phase(column, row), order, periods);
    if (two) {
      constexpr double most = 0.125;  // periods
      const double turns = phases.bands[1].wrapped_phase(column, row) / (2 * std::numbers::pi);
      if (std::abs(std::remainder(layout.bands[1].periods * y - turns, 1)) > most) return;
    }
    result.coordinate(column, row) = y;
    result.doubt(column, row) = 0;
  });
  return result;
}

/// The fringe orders that the neighbours leave standing.
Image<int> voted_orders(Image<int> orders, const Image<CuePixel>& pixels, const CueEvidence& cue,
                        double f_h, int projector_length) {
  Image<double> wrapped_phase(pixels.size());
  Image<std::uint8_t> lit(pixels.size());
  std::transform(pixels.begin(), pixels.end(), wrapped_phase.begin(),
                 [](const CuePixel& pixel) { return pixel.wrapped_phase; });
  std::transform(pixels.begin(), pixels.end(), lit.begin(), [&](const CuePixel& pixel) {
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

/// The fringe order of every pixel by the rule asked for.
Image<int> chosen_orders(const Image<CuePixel>& pixels, const CueEvidence& cue, CueRule rule,
                         double f_h, int projector_length) {
  Image<int> orders(pixels.size());
  std::transform(pixels.begin(), pixels.end(), orders.begin(), [&](const CuePixel& pixel) {
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
  if (rule != CueRule::consensus) return orders;
  return voted_orders(std::move(orders), pixels, cue, f_h, projector_length);
}

UnwrappedPhases unwrap_by_vote(const Layout& layout, const LayoutPhases& phases,
                               const CueSettings& settings, int projector_length,
                               double grey_level) {
  const CueEvidence cue(layout, settings);
  const double f_h = layout.bands.front().periods;
  const Image<CuePixel> pixels = cue_pixels(phases, grey_level);
  const Image<int> orders = chosen_orders(pixels, cue, settings.rule, f_h, projector_length);
  // The published rule leaves the cue of the DC channel in the texture.
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

}  // namespace

UnwrappedPhases unwrap(const Layout& layout, const LayoutPhases& phases, const CueSettings& cue,
                       int projector_length, double grey_level) {
  if (!has_coordinate(layout)) return {};
  if (layout.unwrapping == Unwrapping::vote) {
    return unwrap_by_vote(layout, phases, cue, projector_length, grey_level);
  }
  if (layout.unwrapping == Unwrapping::surfaces) {
    return unwrap_by_surfaces(layout, phases, grey_level * cue.least_modulation);
  }
  return unwrap_alone(layout, phases, projector_length);
}

}  // namespace slipstream
