#pragma once

#include <complex>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "slipstream/base/image.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/maps.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/geometry/triangulator.h"

namespace slipstream {

/// Modulation and phase as one number, B exp(i phi): unlike the phase it has no seam, and it stays
/// smooth where gamma bends the phase, so that it can be interpolated.
using Phasor = std::complex<double>;

/// What one camera knows of every pixel.
struct CameraPhases {
  BasicMaps<double> maps;
  /// Of each band, from few periods to many; of a single one twice, for it is looked for twice.
  std::vector<Image<Phasor>> bands;
  Image<Validity> validity;  ///< too dark, saturated, or valid
};

/// From the first camera's frame to the second's.
struct Stereo {
  Stereo(const Scanner& first, const Scanner& second);

  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;  ///< mm
};

/// The second camera along one ray of the first: what it sees at each depth.
class EpipolarLine {
 public:
  EpipolarLine(const Stereo& stereo, const Lens& camera, const Eigen::Vector3d& ray,
               const CameraPhases& seen)
      : stereo_(stereo), camera_(camera), ray_(ray), seen_(seen) {}

  [[nodiscard]] Eigen::Vector2d pixel(double depth) const;

  /// Phase there minus that of `reference`, around the circle; NaN where a pixel beside the place
  /// is not valid.
  [[nodiscard]] double difference(const Image<Phasor>& phase, Phasor reference, double depth) const;

  /// Depth that moves the place in the second camera by one pixel, mm.
  [[nodiscard]] double depth_of_a_pixel(double depth) const;

 private:
  const Stereo& stereo_;
  const Lens& camera_;
  Eigen::Vector3d ray_;
  const CameraPhases& seen_;
};

/// What a camera sees, and where its pixels' coordinates lie.
struct SeeingCamera {
  const CameraPhases& phases;
  const Triangulator& triangulate;
};

/// Of a single band of many periods, the projector coordinate of each pixel of `camera`: each
/// fringe order names a point, and the order is that of the point that the other camera sees under
/// the same phase. One pixel is not enough, for wrong orders meet the same phase by chance; those
/// of a window count, as far as the phase runs on without a leap from pixel to pixel. NaN where two
/// orders fit, or none. `possible`: whether a surface may be at that point of the camera's frame.
Image<double> order_by_other_camera(const SeeingCamera& camera, const SeeingCamera& other,
                                    double periods,
                                    const std::function<bool(const Eigen::Vector3d&)>& possible);

}  // namespace slipstream
