#pragma once

#include <Eigen/Core>

namespace slipstream {

/// The points origin + distance direction, distance > 0. The direction has any length; distances
/// are in units of it, so that along a camera ray (u, v, 1) they are depths.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
};

/// Where a ray meets a surface.
struct Hit {
  double distance = 0;
  Eigen::Vector3d normal;  ///< of any length and sign
};

}  // namespace slipstream
