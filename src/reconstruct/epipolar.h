#pragma once

#include "geometry/triangulator.h"
#include "slipstream/engine.h"
#include "slipstream/scan.h"

// Epipolar geometry of a camera and the projector: checks with patterns along the other axis.
namespace slipstream {

/// Distance of a projector pixel from the epipolar line of a camera pixel.
struct EpipolarDistance {
  double distance = 0;  ///< projector pixels, signed, in the undistorted image
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< unit normal of the line
};

/// `ray`: of the camera pixel, (u, v, 1) in the camera's frame; `x`, `y`: projector coordinates
/// along both axes. NaN where the projector's lens model has no inverse.
EpipolarDistance epipolar_distance(const Scanner& scanner, const Eigen::Vector3d& ray, double x,
                                   double y);

/// Compares a cloud and its maps, along x, with `other`, a scan of the same scene along y. Sets the
/// maps' epipolar distance. Marks points as `doubtful_order` if they are off their epipolar lines,
/// less the common part of all distances, by more than 5 standard deviations, half a pixel and
/// twice the calibration's own error. Throws Error if the frames of `other` do not fit the setup or
/// do not give coordinates by themselves.
EpipolarCheck check_epipolar(const EngineSetup& setup, const Scan& other, Maps& maps, Cloud& cloud);

}  // namespace slipstream
