#pragma once

#include <optional>
#include <string>

#include "slipstream/decode/decoder.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

struct PhaseMatchSettings {
  /// Half width, pixels of the first camera, of the window in which a plane is fitted to the
  /// matches, weighted by the slope of the phase, which gamma flattens in places. 0: no fit.
  int window = 5;
};

/// Two cameras and one projector, Liu 2010, Section 4.4: a pixel's point is where its ray in the
/// first camera meets a place that the second camera sees under the same phase. Gamma distorts both
/// phases equally and cancels. The projector coordinate only gives the start of the search; for a
/// single band of many periods the second camera's phase also resolves the fringe order.
class PhaseMatcher {
 public:
  /// `first`, `second`: each camera with the same projector. Phases are matched as measured,
  /// without correction. Throws Error if a scanner or a setting is invalid, the projectors differ,
  /// the cameras are in the same place, or the strategy is neither a single band nor bands that
  /// unwrap each other.
  PhaseMatcher(const Scanner& first, const Scanner& second, const Sequence& sequence,
               const ReconstructSettings& settings = {}, const PhaseMatchSettings& match = {});

  /// Result in the first camera's image and frame.
  struct Result {
    Cloud cloud{};
    Maps maps{};  ///< of the first camera
  };

  /// A point for each pixel of the first camera that has a match; `no_point` for the others: hidden
  /// from the second camera, unlit there, or outside its image. Throws Error if frames do not fit.
  [[nodiscard]] Result operator()(const FrameViews& first, const FrameViews& second) const;

  /// Phase method used for frames of either camera.
  [[nodiscard]] std::string method_for(const FrameViews& frames) const {
    return decode_.method_for(frames);
  }

 private:
  EngineSetup first_;
  Scanner second_;
  PhaseMatchSettings match_;
  Triangulator triangulate_;
  std::optional<Triangulator> second_triangulate_;  ///< if needed for the fringe order
  Decoder decode_;
};

}  // namespace slipstream
