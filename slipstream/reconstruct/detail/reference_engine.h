#pragma once

#include <optional>
#include <string>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/uncertainty.h"
#include "slipstream/decode/decoder.h"
#include "slipstream/decode/maps.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/detail/depth_unwrapper.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

/// A scan in 3-D and in double, with what it was made from.
struct ReferenceResult {
  BasicCloud<double> cloud{};
  BasicMaps<double> maps{};
};

/// Frames to cloud in double precision, stage by stage over the whole picture: every layout, any
/// frames, any lens that Triangulator takes. What the fused pass is measured by, and what stands in
/// for it where it cannot.
class ReferenceEngine {
 public:
  /// Throws Error as Engine does. `corrections` are added to the phases.
  ReferenceEngine(const EngineSetup& setup, const PhaseCorrections& corrections);

  /// Throws Error when the frames are not of the camera's size or not as many as the strategy's.
  [[nodiscard]] ReferenceResult operator()(const FrameViews& frames) const;
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames) const;
  /// `validity`: of the fringe order, where the range of depth gives it; else empty.
  [[nodiscard]] BasicMaps<double> maps(const FrameViews& frames, Image<Validity>& validity) const;

  /// Null where no range of depth gives the fringe order.
  [[nodiscard]] const DepthUnwrapper* by_depth() const {
    return unwrap_by_depth_ ? &*unwrap_by_depth_ : nullptr;
  }

  /// See Engine::uncertainty.
  [[nodiscard]] Uncertainty uncertainty(const Cloud& cloud, const Maps& maps,
                                        double full_scale) const;

  [[nodiscard]] std::string method_for(const FrameViews& frames) const {
    return decode_.method_for(frames);
  }

 private:
  /// Why a pixel is left out before it is triangulated, and `valid` where it is not.
  [[nodiscard]] Image<Validity> measured(const BasicMaps<double>& maps, const FrameViews& frames,
                                         const Image<Validity>& order) const;
  [[nodiscard]] BasicCloud<double> triangulated(const Image<double>& coordinates,
                                                Image<Validity> validity) const;
  [[nodiscard]] Validity validity_of(double coordinate, const Eigen::Vector3d& point) const;
  /// |dy / d ln z| of a point along its pixel's ray: how much the projector coordinate changes for
  /// a change of z relative to it. The projector's lens is asked forwards, and no point solved for.
  [[nodiscard]] double change_along_ray(const Eigen::Vector3d& point) const;

  EngineSetup setup_;
  Triangulator triangulate_;
  Decoder decode_;
  std::optional<DepthUnwrapper> unwrap_by_depth_;
};

}  // namespace slipstream
