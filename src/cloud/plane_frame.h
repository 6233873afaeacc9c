#pragma once

#include <array>

#include <Eigen/Geometry>

#include "slipstream/measure.h"

namespace slipstream {

/// A frame found from three planes, as parts are set up in metrology (3-2-1).
struct PlaneFrame {
  /// From the frame of the planes to the new one.
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  /// How far the angle between the normals of each two planes is from a right one, rad, positive if
  /// it is smaller: first and second, first and third, second and third.
  std::array<double, 3> off_square{};
};

/// The frame whose z is the first plane's normal and whose y is the second's as far as it is across
/// z; the third plane sets only the origin, where all three meet. Normals point to the camera.
/// Throws Error if two planes are within 20 degrees of parallel, or the three meet along a line.
PlaneFrame frame_of_planes(const std::array<FittedPlane, 3>& planes);

}  // namespace slipstream
