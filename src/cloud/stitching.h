#pragma once

#include <cstddef>

#include <Eigen/Geometry>

#include "slipstream/cloud.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// How well two views of the same scene meet.
struct Stitching {
  std::size_t points = 0;  ///< of the second view, seen in the first too
  /// Distances of these points from the surface of the first view, mm.
  double median = 0, percentile_95 = 0;
  double left_median = 0;  ///< after the best move of the second view
  /// The second view's offset from the first at the middle of the overlap, mm, along the axes of
  /// the first camera, and its rotation, rad.
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  double rotation = 0;
};

/// `second_to_first`: from the second view's camera to the first's, as the robot and the hand-eye
/// pose say. Both clouds are organised. Finds the offset by registration, starting there. Throws
/// Error if a cloud does not have the camera's size, or the views share too few points.
Stitching stitched(const Cloud& first, const Cloud& second, const Lens& camera,
                   const Eigen::Isometry3d& second_to_first);

}  // namespace slipstream
