#include "reconstruct/engine_setup.h"

#include <algorithm>

#include "base/throw_if-inl.h"
#include "decode/cue_evidence.h"
#include "decode/phase_decoder.h"
#include "response/correction.h"
#include "slipstream/unwrapping.h"

namespace slipstream {

void require_size(const FrameViews& frames, Size camera) {
  if (frames.size() == camera) return;
  throw Error(fmt::format("frames are {}, the scanner's camera has {}; both must agree",
                          text_of(frames.size()), text_of(camera)));
}

bool unwraps_by_depth(const EngineSetup& setup) {
  return !has_coordinate(setup.sequence.strategy) && setup.settings.nearest &&
         setup.settings.farthest;
}

bool unwraps_by_picture(const EngineSetup& setup) {
  return unwraps_by_depth(setup) ||
         order_source(setup.sequence.strategy.layout()) == OrderSource::surface;
}

CueSettings cue_settings(const EngineSetup& setup) {
  const PhotometricCalibration& known = setup.scanner.photometry;
  CueSettings cue{.light = setup.sequence.light, .rule = setup.settings.cue_rule};

  // A calibrated value replaces the default.
  cue.ambient = known.ambient.value_or(cue.ambient);
  cue.noise_variance = known.noise_variance.value_or(cue.noise_variance);

  return cue;
}

PhaseCorrections phase_corrections(const EngineSetup& setup) {
  const auto& measured = setup.scanner.photometry.response;
  if (!measured) return {};
  return phase_corrections(measured->response, setup.sequence.strategy.layout());
}

int projector_length(const EngineSetup& setup) {
  return length_along(setup.sequence.axis, setup.scanner.projector.size);
}

double least_modulation(const EngineSetup& setup) {
  const Layout& layout = setup.sequence.strategy.layout();
  const double least = setup.settings.minimum_modulation;
  if (order_source(layout) != OrderSource::neighbours) return least;
  return std::max(least, CueEvidence(layout, cue_settings(setup)).least_modulation());
}

void raise_least_modulation(EngineSetup& setup) {
  const double least = least_modulation(setup);
  ReconstructSettings& settings = setup.settings;
  if (!(least > settings.minimum_modulation)) return;

  // The product of both stays the same, and with it the pixels that vote.
  settings.least_voting_share *= settings.minimum_modulation / least;
  settings.minimum_modulation = least;
}

double least_modulation(const ReconstructSettings& settings, double full_scale) {
  return settings.minimum_modulation * full_scale / 255;
}

double least_neighbour_modulation(const ReconstructSettings& settings, double full_scale) {
  return settings.least_voting_share * least_modulation(settings, full_scale);
}

}  // namespace slipstream
