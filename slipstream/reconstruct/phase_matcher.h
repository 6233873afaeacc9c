#pragma once

#include <string>

#include "slipstream/capture/frame_set.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/reconstructor.h"
#include "slipstream/strategy/decoder.h"

namespace slipstream {

/// How the phases of two cameras are matched.
struct PhaseMatchSettings {
  /// Half the width, pixels of the first camera, of the window through whose matches a plane is
  /// laid, each weighed by how steeply its phase runs: where gamma flattens the phase, neighbours
  /// say more. 0: each pixel by itself.
  int window = 5;
};

/// Two cameras and one projector, Liu 2010, Section 4.4: the point of a pixel is where the ray of
/// the first camera meets a place that the second sees under the same phase. Gamma bends both
/// phases alike and drops out. The projector's place only says where to begin to look.
class PhaseMatcher {
 public:
  /// `first`, `second`: each camera with the one projector. Phases are matched as they are
  /// measured, without the settings' corrections. Throws Error where a scanner or the settings are
  /// not valid, the projectors differ, the cameras stand in one place, or the strategy's frames do
  /// not give a projector coordinate by sinusoids alone, as those of PCMP.
  PhaseMatcher(const Scanner& first, const Scanner& second, const Strategy& strategy, Axis axis,
               const ReconstructSettings& settings = {}, const PhaseMatchSettings& match = {});

  /// The cloud in the first camera's frame, a point for each of its pixels that finds its match;
  /// `no_point` where none is found: hidden from the second camera, unlit there, or outside its
  /// picture. Throws Error when frames are not of their camera's size or not as many as the
  /// strategy's.
  [[nodiscard]] Reconstruction operator()(const FrameSet& first, const FrameSet& second) const;

  /// See Reconstructor::backend_for; of the frames of either camera.
  [[nodiscard]] std::string backend_for(const FrameSet& frames) const {
    return decode_.backend_for(frames);
  }

 private:
  Scanner first_;
  Scanner second_;
  Strategy strategy_;
  ReconstructSettings settings_;
  PhaseMatchSettings match_;
  Triangulator triangulate_;
  Decoder decode_;
  PhaseDecoder phase_;
};

}  // namespace slipstream
