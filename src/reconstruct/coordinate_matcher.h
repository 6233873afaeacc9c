#pragma once

#include "slipstream/engine.h"
#include "slipstream/scan.h"

namespace slipstream {

/// Direction of a pixel's ray relative to the baseline of two cameras.
struct EpipolarRay {
  double angle = 0;      ///< of its epipolar plane about the baseline, rad
  double cotangent = 0;  ///< of its angle to the baseline
};

/// Two calibrated cameras and a projector of unknown calibration: a pixel's point is where its ray
/// meets that of the place in the second camera with the same projector coordinate on the same
/// epipolar line, interpolated between pixels. Needs no rectified pictures.
class CoordinateMatcher {
 public:
  /// `pair`: its `projector` is the second camera; its response is ignored. Builds tables for both
  /// cameras. Throws Error if the pair is invalid, or frames of the strategy give no coordinate.
  CoordinateMatcher(const Scanner& pair, const Sequence& sequence,
                    const ReconstructSettings& settings = {});

  /// Result in the first camera's image and frame.
  struct Result {
    Cloud cloud{};
    /// The first camera's, along the scan's own axis; coordinate NaN where invalid.
    Maps maps{};
    /// From both cameras' noise; of stripes, from their pixel size. Its coordinate is the matched
    /// one.
    Uncertainty uncertainty{};
  };

  /// A point for each pixel with one match in the depth range: `no_point` without a match,
  /// `doubtful_order` with several, `low_trust` above CleanSettings::largest_sigma; then cleaned.
  /// With patterns along both axes, matches the coordinate that changes more along the epipolar
  /// lines; the other excludes wrong places. Throws Error without a further camera, or if the size
  /// or number of frames is wrong.
  [[nodiscard]] Result operator()(const Scan& scan) const;

 private:
  EngineSetup setup_;
  Eigen::Matrix3d frame_;  ///< rows: along the baseline, and two directions across it
  Image<EpipolarRay> first_, second_;
};

}  // namespace slipstream
