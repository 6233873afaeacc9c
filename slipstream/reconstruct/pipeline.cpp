// From the frames of a scan to its cloud: the method of Liu 2010, whole and in the order of its
// stages. A setup names scanner, patterns and settings; equation numbers are the dissertation's.
#include "slipstream/reconstruct/pipeline.h"

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

PointMethod point_method(PhaseMethod method) {
  if (method == PhaseMethod::closed_form) return PointMethod::form1;
  return method == PhaseMethod::tables ? PointMethod::form3 : PointMethod::inverse;
}

}  // namespace

void require_size(const FrameViews& frames, Size camera) {
  if (frames.size() == camera) return;
  throw Error(fmt::format("frames are {}, the scanner's camera has {}; both must agree",
                          text_of(frames.size()), text_of(camera)));
}

ReferenceEngine::ReferenceEngine(const EngineSetup& setup, const PhaseCorrections& corrections)
    : setup_(setup),
      triangulate_(setup.scanner, setup.sequence.axis, point_method(setup.settings.phase_method)),
      decode_(setup.sequence.strategy.layout(), projector_length(setup),
              setup.settings.phase_method, corrections, cue_settings(setup)) {
  if (unwraps_by_depth(setup)) unwrap_by_depth_.emplace(setup);
}

BasicMaps<double> ReferenceEngine::maps(const FrameViews& frames, Image<Validity>& order) const {
  require_size(frames, setup_.scanner.camera.size);
  // Mean A, modulation B and phase of every sinusoid, (1.3)-(1.7): by the equations, the closed
  // forms or the tables, (2.1)-(2.18). Each phase is corrected for the projector's response, Ch. 4.
  LayoutPhases phases = decode_.demodulate(frames);
  // Fringe order, and so the coordinate y on the projector: from band to band (1.17), by a code, or
  // by a cue and the neighbours' vote, Ch. 3.
  BasicMaps<double> maps =
      decode_.unwrapped(std::move(phases), frames.full_scale(),
                        least_neighbour_modulation(setup_.settings, frames.full_scale()));
  // One band of many periods: the order by which the point lies in the range of depth.
  if (unwrap_by_depth_) order = (*unwrap_by_depth_)(maps, frames.full_scale());
  return maps;
}

ReferenceResult ReferenceEngine::operator()(const FrameViews& frames) const {
  Image<Validity> order;
  BasicMaps<double> maps = this->maps(frames, order);
  // What a pixel is left out for: too dark, saturated, contradicted by its neighbours.
  Image<Validity> validity = judged(maps, order, frames, setup_);
  // The ray of the pixel meets the light plane of y, (1.15) or one of its forms, (2.21)-(2.31).
  BasicCloud<double> cloud =
      triangulated(maps.coordinate, std::move(validity), triangulate_, setup_);
  // The texture is the mean A, in which the patterns do not show.
  std::transform(maps.mean.begin(), maps.mean.end(), cloud.intensity.begin(), [&](double mean) {
    return static_cast<float>(mean / (frames.full_scale() / 255));
  });
  return {std::move(cloud), std::move(maps)};  // to be cleaned, see Engine::run
}

void ReferenceEngine::run(const FrameViews& frames, const Outputs& outputs) const {
  ReferenceResult result;
  if (outputs.makes_points()) {
    result = (*this)(frames);
  } else {
    result.maps = maps(frames);
  }
  const auto& [cloud, maps] = result;
  if (outputs.cloud != nullptr) convert(cloud, *outputs.cloud);
  if (outputs.maps != nullptr) convert(maps, *outputs.maps);
  if (outputs.modulation != nullptr) convert(maps.modulation, *outputs.modulation);
  if (outputs.depth != nullptr) {
    convert(cloud.z, outputs.depth->z);
    outputs.depth->validity = cloud.validity;
  }
  if (outputs.depth16 != nullptr) {
    const Image<float> z = converted<float>(cloud.z);
    *outputs.depth16 = Image<std::uint16_t>(z.size());
    std::transform(z.begin(), z.end(), outputs.depth16->begin(), outputs.scale);
  }
}

}  // namespace slipstream
