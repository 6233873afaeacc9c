#include "slipstream/decode/decoder.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/unwrapping.h"
#include "slipstream/decode/unwrap.h"

namespace slipstream {
namespace {

/// By the layout's rule; `grey_level`: one of 8 bits in those of the frames.
UnwrappedPhases unwrap(const Layout& layout, const LayoutPhases& phases, const CueSettings& cue,
                       int projector_length, double grey_level) {
  if (!has_coordinate(layout)) return {};
  switch (order_source(layout)) {
    case OrderSource::neighbours:
      return unwrap_by_vote(layout, phases, cue, projector_length, grey_level);
    case OrderSource::surface:
      return unwrap_by_surfaces(layout, phases, grey_level * cue.least_modulation);
    default:
      return unwrap_pixels(layout, phases, projector_length);
  }
}

/// The least modulation of all bands, the rest as the measuring band has it.
BasicMaps<double> maps_of(std::vector<PhaseMaps> bands, std::size_t measuring,
                          UnwrappedPhases unwrapped) {
  PhaseMaps& fine = bands[measuring];
  for (const PhaseMaps& band : bands) {
    std::transform(fine.modulation.begin(), fine.modulation.end(), band.modulation.begin(),
                   fine.modulation.begin(), [](double a, double b) { return std::min(a, b); });
  }
  std::transform(unwrapped.shade.begin(), unwrapped.shade.end(), fine.mean.begin(),
                 fine.mean.begin(), [](double shade, double mean) { return mean - shade; });
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
  if (frames.count() != layout_.frames) {
    throw Error(
        fmt::format("{} frames given; the patterns are {}", frames.count(), layout_.frames));
  }
  const bool votes = order_source(layout_) == OrderSource::neighbours;
  const std::size_t decoded = votes ? 1 : layout_.bands.size();
  LayoutPhases phases;
  for (std::size_t i = 0; i < decoded; ++i)
    phases.bands.push_back(phase_(frames, layout_.bands[i]));
  if (votes && layout_.cue) {
    phases.cue = weighted_sum(frames, layout_.cue->weights);
  } else if (votes) {
    phases.cue = weighted_sum(frames, layout_.bands[1].cosine);
    phases.cue_sine = weighted_sum(frames, layout_.bands[1].sine);
  }
  if (layout_.code || !layout_.single_frames.empty()) phases.frames = frames;
  return phases;
}

BasicMaps<double> Decoder::unwrapped(LayoutPhases phases, double full_scale,
                                     double least_modulation) const {
  const double grey_level = full_scale / 255;
  CueSettings cue = cue_;
  cue.least_modulation = std::max(cue.least_modulation, least_modulation / grey_level);
  UnwrappedPhases unwrapped = unwrap(layout_, phases, cue, projector_length_, grey_level);
  if (!unwrapped.contrast.empty()) {
    phases.bands.front().modulation = std::move(unwrapped.contrast);
  }
  const std::size_t measuring =
      order_source(layout_) == OrderSource::neighbours ? 0 : measuring_band_index(layout_);
  return maps_of(std::move(phases.bands), measuring, std::move(unwrapped));
}

std::string Decoder::method_for(const FrameViews& frames) const {
  std::string names;
  const bool votes = order_source(layout_) == OrderSource::neighbours;
  const std::size_t decoded = votes ? 1 : layout_.bands.size();
  for (std::size_t i = 0; i < decoded; ++i) {
    const std::string name(name_of(phase_.method_for(layout_.bands[i], frames)));
    if (names.empty()) {
      names = name;
    } else if (names != name) {
      names += ", " + name;
    }
  }
  return names;
}

}  // namespace slipstream
