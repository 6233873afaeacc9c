#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/maps.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

/// How far a projector pixel lies from the epipolar line of a camera pixel.
struct EpipolarDistance {
  double distance = 0;  ///< projector pixels, signed, in the picture without the lens's distortion
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< of the line, unit length
};

/// `ray`: of the camera pixel, (u, v, 1) in its frame; `x`, `y`: projector coordinates along both
/// axes. NaN where the projector's lens model has no inverse.
EpipolarDistance epipolar_distance(const Scanner& scanner, const Eigen::Vector3d& ray, double x,
                                   double y);

/// What the patterns along the other axis say of a scan. An error of either coordinate shows as far
/// as it leads across the epipolar line: where that runs along x, mistakes of x alone do not.
struct EpipolarCheck {
  double median = 0;         ///< of the distances of points, projector pixels
  double median_length = 0;  ///< likewise without their signs
  double median_sigma = 0;   ///< what noise does to it: one standard deviation
  std::size_t doubted = 0;   ///< points that lay farther off than noise explains

  /// Whether the distances are far beyond noise, so that calibration and scan do not fit.
  [[nodiscard]] bool contradicts() const;
};

/// Compares a cloud and its maps, along x, with `other`, the same seen under patterns along y:
/// sets the maps' epipolar distance and makes points farther than 5 standard deviations, or half a
/// pixel where that is more, from their epipolar lines `doubtful_order`; all of them where more
/// than a third are: the others lie there by chance. Throws Error where its frames do not fit the
/// setup or give no coordinate alone.
EpipolarCheck check_epipolar(const EngineSetup& setup, const Scan& other, Maps& maps, Cloud& cloud);

}  // namespace slipstream
