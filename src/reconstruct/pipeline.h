#pragma once

#include <optional>
#include <string>

#include "decode/decoder.h"
#include "decode/phase_decoder.h"
#include "decode/surface_orders.h"
#include "geometry/triangulator.h"
#include "reconstruct/depth_unwrapper.h"
#include "slipstream/engine.h"

namespace slipstream {

/// Cloud of a scan in double precision, with the maps it was made from.
struct ReferenceResult {
  BasicCloud<double> cloud{};
  BasicMaps<double> maps{};
};

/// Reference implementation: double precision, stage by stage over the whole image, for every
/// layout, frame format and lens that Triangulator supports. The fused pass and the GPU are tested
/// against it, and it replaces them where they cannot be used. Read pipeline.cpp for the stages.
/// Builds its tables once. Thread-safe.
class ReferenceEngine {
 public:
  /// Throws Error as Engine's constructor does. `corrections` are added to the phases.
  ReferenceEngine(const EngineSetup& setup, const PhaseCorrections& corrections);

  // Both throw Error if the size or number of frames is wrong. Engine cleans the cloud.
  [[nodiscard]] ReferenceResult operator()(const FrameViews& frames) const;
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames) const {
    Image<Validity> order;
    return maps(frames, order);
  }

  /// Computes the requested outputs, converted to float.
  void run(const FrameViews& frames, const Outputs& outputs) const;

  /// Null if the fringe order does not come from the depth range.
  [[nodiscard]] const DepthUnwrapper* by_depth() const {
    return unwrap_by_depth_ ? &*unwrap_by_depth_ : nullptr;
  }

  /// See Decoder::method_for.
  [[nodiscard]] std::string method_for(const FrameViews& frames) const {
    return decode_.method_for(frames);
  }

 private:
  /// `order`: why the depth range gives a pixel no fringe order; no pixels if it is not used.
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames, Image<Validity>& order) const;

  EngineSetup setup_;
  Triangulator triangulate_;
  Decoder decode_;
  std::optional<DepthUnwrapper> unwrap_by_depth_;
};

}  // namespace slipstream
