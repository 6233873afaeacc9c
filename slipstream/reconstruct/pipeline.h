#pragma once

#include <optional>
#include <string>

#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/decoder.h"
#include "slipstream/decode/maps.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/depth_unwrapper.h"
#include "slipstream/reconstruct/outputs.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

/// A scan in 3-D and in double, with what it was made from.
struct ReferenceResult {
  BasicCloud<double> cloud{};
  BasicMaps<double> maps{};
};

/// The algorithm itself, in double and stage by stage over the whole picture: every layout, any
/// frames, any lens that Triangulator takes. What the fused pass and the GPU are measured by, and
/// what stands in for them where they cannot. Read pipeline.cpp for the order of the stages.
/// Tables are built once. Thread-safe.
class ReferenceEngine {
 public:
  /// Throws Error as Engine does. `corrections` are added to the phases.
  ReferenceEngine(const EngineSetup& setup, const PhaseCorrections& corrections);

  // Each throws Error when the frames are not of the camera's size or not as many as the
  // strategy's. Nothing is cleaned: Engine cleans the clouds of all engines alike.
  [[nodiscard]] ReferenceResult operator()(const FrameViews& frames) const;
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames) const {
    Image<Validity> order;
    return maps(frames, order);
  }
  /// The same in float, as far as it is wanted.
  void run(const FrameViews& frames, const Outputs& outputs) const;

  /// Null where no range of depth gives the fringe order.
  [[nodiscard]] const DepthUnwrapper* by_depth() const {
    return unwrap_by_depth_ ? &*unwrap_by_depth_ : nullptr;
  }
  /// See Decoder::method_for.
  [[nodiscard]] std::string method_for(const FrameViews& frames) const {
    return decode_.method_for(frames);
  }

 private:
  /// `order`: why the range of depth gives a pixel no fringe order; empty where it gives none.
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames, Image<Validity>& order) const;

  EngineSetup setup_;
  Triangulator triangulate_;
  Decoder decode_;
  std::optional<DepthUnwrapper> unwrap_by_depth_;
};

// Stages of the pipeline that belong to no room above this one.

/// Why the frames leave a pixel out, `valid` where they do not: too dark, saturated, or of a fringe
/// order that its neighbours do not confirm; else what `order` says of it, unless that is empty.
Image<Validity> judged(const BasicMaps<double>& maps, const Image<Validity>& order,
                       const FrameViews& frames, const EngineSetup& setup);

/// The points of the pixels that are valid and whose point lies before camera and projector, in the
/// projector's field and in the range of depth. Its intensity is not set.
BasicCloud<double> triangulated(const Image<double>& coordinates, Image<Validity> validity,
                                const Triangulator& triangulate, const EngineSetup& setup);

/// How sure each point of a cloud is under noise of the scanner's variance: see
/// Engine::uncertainty. `full_scale`: of the frames.
Uncertainty uncertainty_of(const Cloud& cloud, const Maps& maps, const EngineSetup& setup,
                           double full_scale);

}  // namespace slipstream
