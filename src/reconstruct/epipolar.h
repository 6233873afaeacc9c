#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

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

/// A camera pixel, and the projector coordinates that it sees.
struct SeenPixel {
  Eigen::Vector2d camera;
  double x = 0, y = 0;
};

/// Comparison of a scan with its guard.
struct GuardCheck {
  EpipolarCheck epipolar{};
  std::size_t measured = 0;         ///< pixels of the scan that could be compared
  std::vector<SeenPixel> pixels{};  ///< up to a thousand that the common part fits
};

/// Compares a cloud and its maps, along either axis, with the scan's guard, see Scan::guard, as
/// check_epipolar does; rejects no point. Also compares pixels whose point lies out of range, as a
/// scanner file of another rig leaves few others, and those outside the user's limits. Throws Error
/// as check_epipolar.
GuardCheck check_guard(const EngineSetup& setup, const Scan& guard, const Maps& maps,
                       const Cloud& cloud);

}  // namespace slipstream
