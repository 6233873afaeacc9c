#pragma once

#include <optional>
#include <string>

#include "slipstream/decode/decoder.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

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
/// phases alike and drops out. The projector's place only says where to begin to look; where one
/// band of many periods leaves the fringe order open, the second camera's phase says it as well.
class PhaseMatcher {
 public:
  /// `first`, `second`: each camera with the one projector. Phases are matched as they are
  /// measured, without a correction. Throws Error where a scanner or the settings are not valid,
  /// the projectors differ, the cameras stand in one place, or the strategy is not of one band or
  /// bands that unwrap each other.
  PhaseMatcher(const Scanner& first, const Scanner& second, const Sequence& sequence,
               const ReconstructSettings& settings = {}, const PhaseMatchSettings& match = {});

  /// What the two cameras give together, in the first one's picture and frame.
  struct Result {
    Cloud cloud{};
    Maps maps{};  ///< of the first camera
  };

  /// A point for each pixel of the first camera that finds its match; `no_point` where none is
  /// found: hidden from the second camera, unlit there, or outside its picture. Throws Error when
  /// frames are not of their camera's size or not as many as the strategy's.
  [[nodiscard]] Result operator()(const FrameViews& first, const FrameViews& second) const;

  /// How the phases of either camera's frames are computed.
  [[nodiscard]] std::string method_for(const FrameViews& frames) const {
    return decode_.method_for(frames);
  }

 private:
  EngineSetup first_;
  Scanner second_;
  PhaseMatchSettings match_;
  Triangulator triangulate_;
  std::optional<Triangulator> second_triangulate_;  ///< where the second tells the fringe order
  Decoder decode_;
};

}  // namespace slipstream
