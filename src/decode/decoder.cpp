#include "decode/decoder.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "decode/cue_evidence.h"
#include "decode/phase_decoder.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// By the layout's method; `grey_level`: one 8-bit grey level in units of the frames.
UnwrappedPhases unwrap(const Layout& layout, const LayoutPhases& phases, const CueSettings& cue,
                       int projector_length, double grey_level) {
  if (!has_coordinate(layout)) return {};
  switch (order_source(layout)) {
    case OrderSource::neighbours:
      return unwrap_by_vote(layout, phases, cue, projector_length, grey_level);
    case OrderSource::surface:
      return unwrap_by_surfaces(layout, phases, grey_level * cue.least_modulation);
    default:
      return unwrap_pixels(layout, phases, projector_length,
                           grey_level * std::sqrt(cue.noise_variance));
  }
}

/// All bands; only the measuring one if the layout votes.
std::span<const Band> decoded_bands(const Layout& layout) {
  const bool votes = order_source(layout) == OrderSource::neighbours;
  return std::span(layout.bands).first(votes ? 1 : layout.bands.size());
}

/// The least modulation of all bands; the rest from the measuring band.
BasicMaps<double> maps_of(std::vector<PhaseMaps> bands, std::size_t measuring,
                          UnwrappedPhases unwrapped) {
  PhaseMaps& fine = bands[measuring];
  for (const PhaseMaps& band : bands) {
    std::ranges::transform(fine.modulation, band.modulation, fine.modulation.begin(),
                           [](double a, double b) { return std::min(a, b); });
  }

  std::ranges::transform(fine.mean, unwrapped.shade, fine.mean.begin(), std::minus<>());

  return {.mean = std::move(fine.mean),
          .modulation = std::move(fine.modulation),
          .wrapped_phase = std::move(fine.wrapped_phase),
          .fringe_order_doubt = std::move(unwrapped.doubt),
          .coordinate = std::move(unwrapped.coordinate)};
}

}  // namespace

Decoder::Decoder(Layout layout, int projector_length, PhaseMethod method,
                 PhaseCorrections corrections, const CueSettings& cue)
    : layout_(std::move(layout)),
      projector_length_(projector_length),
      cue_(cue),
      phase_(method, step_counts(layout_), std::move(corrections)) {
  require_valid(cue_);
}

BasicMaps<double> Decoder::operator()(const FrameViews& frames, double least_modulation) const {
  return unwrapped(demodulate(frames), frames.full_scale(), least_modulation);
}

LayoutPhases Decoder::demodulate(const FrameViews& frames) const {
  throw_if(frames.count() != layout_.frames, "{} frames given; expected {}", frames.count(),
           layout_.frames);

  LayoutPhases phases;
  for (const Band& band : decoded_bands(layout_)) phases.bands.push_back(phase_(frames, band));

  // The cue is a weighted sum of frames, or a second band as C and S.
  if (layout_.cue) {
    phases.cue = weighted_sum(frames, layout_.cue->weights);
  } else if (order_source(layout_) == OrderSource::neighbours) {
    phases.cue = weighted_sum(frames, layout_.bands[1].cosine);
    phases.cue_sine = weighted_sum(frames, layout_.bands[1].sine);
  }

  // Codes and single frames are read from the frames themselves.
  if (layout_.code || !layout_.single_frames.empty() || layout_.unwrapping->pixel != nullptr)
    phases.frames = frames;

  return phases;
}

BasicMaps<double> Decoder::unwrapped(LayoutPhases phases, double full_scale,
                                     double least_modulation) const {
  // The cue counts in grey levels of 8 bits.
  const double grey_level = full_scale / 255;
  CueSettings cue = cue_;
  cue.least_modulation = std::max(cue.least_modulation, least_modulation / grey_level);

  UnwrappedPhases unwrapped = unwrap(layout_, phases, cue, projector_length_, grey_level);

  // A code alone has no sinusoid: its contrast takes the place of the modulation.
  if (!unwrapped.contrast.empty()) phases.bands.front().modulation = std::move(unwrapped.contrast);
  return maps_of(std::move(phases.bands), measuring_band_index(layout_), std::move(unwrapped));
}

std::string Decoder::method_for(const FrameViews& frames) const {
  std::string names;

  for (const Band& band : decoded_bands(layout_)) {
    const std::string name(name_of(phase_.method_for(band, frames)));
    if (names != name) names += names.empty() ? name : ", " + name;
  }

  return names;
}

Image<std::uint8_t> modulation_mask(const Image<double>& modulation, double minimum) {
  Image<std::uint8_t> mask(modulation.size());
  std::ranges::transform(modulation, mask.begin(),
                         [minimum](double B) -> std::uint8_t { return B >= minimum ? 1 : 0; });
  return mask;
}

Image<std::uint8_t> unconfirmed_fringe_orders(const Image<double>& coordinate,
                                              const Image<double>& doubt,
                                              const Image<std::uint8_t>& lit, double frequency,
                                              const FringeOrderConsensus& settings) {
  Image<std::uint8_t> unconfirmed(coordinate.size());
  for_each_pixel(coordinate.size(), [&](int column, int row) {
    if (lit(column, row) == 0) return;

    const int wanted = doubt(column, row) > settings.largest_doubt ? settings.fewest_if_doubtful
                                                                   : settings.fewest_neighbours;

    // Lit neighbours within half a fringe.
    const double y = coordinate(column, row);
    int agreeing = 0;
    for (int r = std::max(row - 1, 0); r <= std::min(row + 1, lit.height() - 1); ++r) {
      for (int c = std::max(column - 1, 0); c <= std::min(column + 1, lit.width() - 1); ++c) {
        if (lit(c, r) == 0 || (c == column && r == row)) continue;
        if (std::abs(coordinate(c, r) - y) < 0.5 / frequency) ++agreeing;
      }
    }

    unconfirmed(column, row) = agreeing >= wanted ? 0 : 1;
  });

  return unconfirmed;
}

}  // namespace slipstream
