#pragma once

#include <functional>

#include <Eigen/Core>

#include "slipstream/base/image.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/detail/epipolar_line.h"

namespace slipstream {

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
