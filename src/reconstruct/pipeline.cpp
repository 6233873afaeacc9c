// Frames to point cloud by the method of Liu 2010, stage by stage. EngineSetup holds the scanner,
// the patterns and the settings; numbers in parentheses are equations of the dissertation.
#include "reconstruct/pipeline.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>

#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/points.h"
#include "slipstream/error.h"

namespace slipstream {

ReferenceEngine::ReferenceEngine(const EngineSetup& setup, const PhaseCorrections& corrections)
    : setup_(setup),
      triangulate_(setup.scanner, setup.sequence.axis,
                   setup.settings.phase_method == PhaseMethod::closed_form ? PointMethod::form1
                   : setup.settings.phase_method == PhaseMethod::tables    ? PointMethod::form3
                                                                           : PointMethod::inverse),
      decode_(setup.sequence.strategy.layout(), projector_length(setup),
              setup.settings.phase_method, corrections, cue_settings(setup)) {
  if (unwraps_by_depth(setup)) unwrap_by_depth_.emplace(setup);
}

BasicMaps<double> ReferenceEngine::maps(const FrameViews& frames, Image<Validity>& order) const {
  require_size(frames, setup_.scanner.camera.size);

  // 1. Demodulate: mean A, modulation B and wrapped phase of every band, (1.3)-(1.7), by the
  //    equations, the closed forms or the lookup tables (2.1)-(2.18). Correct each phase for the
  //    projector's response, Ch. 4.
  LayoutPhases phases = decode_.demodulate(frames);

  // 2. Unwrap: find each pixel's fringe order, and with it the projector coordinate y. The order
  //    comes from a lower frequency (1.17), a binary code, or a cue and the vote of the neighbours,
  //    Ch. 3.
  BasicMaps<double> maps =
      decode_.unwrapped(std::move(phases), frames.full_scale(),
                        least_neighbour_modulation(setup_.settings, frames.full_scale()));

  // With a single band of many periods, the fringe order comes from the depth range.
  if (unwrap_by_depth_) order = (*unwrap_by_depth_)(maps, frames.full_scale());

  return maps;
}

ReferenceResult ReferenceEngine::operator()(const FrameViews& frames) const {
  Image<Validity> order;
  BasicMaps<double> maps = this->maps(frames, order);

  // 3. Reject pixels that are too dark, saturated, or contradicted by their neighbours.
  Image<Validity> validity = judged(maps, order, frames, setup_);

  // 4. Triangulate: intersect the pixel's ray with the light plane of y, (1.15) or one of its
  //    faster forms (2.21)-(2.31). Reject points outside the projector's field or the depth range.
  BasicCloud<double> cloud =
      triangulated(maps.coordinate, std::move(validity), triangulate_, setup_);

  // 5. Intensity: the mean A, in which the patterns cancel, on a scale of 0 to 255.
  std::ranges::transform(maps.mean, cloud.intensity.begin(), [&](double mean) {
    return static_cast<float>(mean / (frames.full_scale() / 255));
  });

  return {std::move(cloud), std::move(maps)};
}

void ReferenceEngine::run(const FrameViews& frames, const Outputs& outputs) const {
  // Maps alone do not need the last three stages.
  ReferenceResult result;
  if (outputs.makes_points()) {
    result = (*this)(frames);
  } else {
    result.maps = maps(frames);
  }

  // The outputs are in float, whatever the engine computes in.
  const auto& [cloud, maps] = result;
  if (outputs.cloud != nullptr) convert(cloud, *outputs.cloud);
  if (outputs.maps != nullptr) convert(maps, *outputs.maps);
  if (outputs.modulation != nullptr) convert(maps.modulation, *outputs.modulation);

  if (outputs.depth != nullptr) {
    convert(cloud.z, outputs.depth->z);
    outputs.depth->validity = cloud.validity;
  }

  // Quantised from float as in the other engines, so that all round in the same way.
  if (outputs.depth16 != nullptr) {
    const Image<float> z = converted<float>(cloud.z);
    *outputs.depth16 = Image<std::uint16_t>(z.size());
    std::ranges::transform(z, outputs.depth16->begin(), outputs.scale);
  }
}

}  // namespace slipstream
