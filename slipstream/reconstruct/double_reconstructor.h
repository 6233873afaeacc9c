#pragma once

#include <string>

#include "slipstream/cloud/uncertainty.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/reconstruct_settings.h"
#include "slipstream/reconstruct/reconstruction.h"
#include "slipstream/strategy/decoder.h"

namespace slipstream {

/// Frames to cloud in double precision, stage by stage over the whole picture: every strategy, any
/// frames, any lens that Triangulator takes. What the fused pass is measured by, and what stands in
/// for it where it cannot.
class DoubleReconstructor {
 public:
  /// Scanner, strategy and settings as Reconstructor takes them; the backend `fused` is `lut` here.
  DoubleReconstructor(const Scanner& scanner, const Strategy& strategy, Axis axis,
                      const ReconstructSettings& settings);

  /// Throws Error when the frames are not of the camera's size or not as many as the strategy's.
  [[nodiscard]] Reconstruction operator()(const FrameSet& frames) const;

  /// See Reconstructor::uncertainty.
  [[nodiscard]] Uncertainty uncertainty(const Reconstruction& scan, const FrameSet& frames) const;

  [[nodiscard]] std::string backend_for(const FrameSet& frames) const {
    return decode_.backend_for(frames);
  }

 private:
  /// Why a pixel is left out before it is triangulated, and `valid` where it is not.
  [[nodiscard]] Image<Validity> measured(const DecodedScan& decoded, const FrameSet& frames) const;
  [[nodiscard]] Cloud triangulated(const DecodedScan& decoded, Image<Validity> validity) const;
  [[nodiscard]] Validity validity_of(double coordinate, const Eigen::Vector3d& point) const;

  ReconstructSettings settings_;
  Axis axis_;
  Strategy strategy_;
  double highest_frequency_;
  Triangulator triangulate_;
  Decoder decode_;
};

}  // namespace slipstream
