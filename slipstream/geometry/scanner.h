#pragma once

#include <Eigen/Core>

#include "slipstream/geometry/lens.h"
#include "slipstream/pattern/axis.h"

namespace slipstream {

/// A calibrated camera-projector pair. The world is the camera's frame: millimetres, X to the right
/// and Y down in the picture, Z forward. A point X in it is at rotation X + translation in the
/// projector's frame.
struct Scanner {
  Lens camera;
  Lens projector;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< mm
};

/// Throws Error unless both lenses are valid with a size, the rotation is one (to 1e-4) and the
/// baseline is finite and not zero.
void require_valid(const Scanner& scanner);

/// Throws Error when patterns along `axis` carry no depth for this scanner: the baseline runs along
/// the stripes, so that every ray meets the same stripe at every depth and Eq. (1.15) is singular.
void require_depth_visible(const Scanner& scanner, Axis axis);

/// A point of the camera's frame in the projector's.
Eigen::Vector3d in_projector_frame(const Scanner& scanner, const Eigen::Vector3d& point);

/// Centre of the projector in the camera's frame, mm. Its length is the baseline.
Eigen::Vector3d projector_centre(const Scanner& scanner);

/// Projector coordinate y = pixel / length, along `axis`, of a projector pixel.
double coordinate_along(Axis axis, const Eigen::Vector2d& pixel, Size projector);

}  // namespace slipstream
