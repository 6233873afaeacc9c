#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Geometry>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/normals.h"
#include "slipstream/geometry/lens.h"

namespace slipstream {

/// A small piece of an object's surface, in the object's frame.
struct ModelElement {
  Eigen::Vector3f position;  ///< mm
  Eigen::Vector3f normal;    ///< unit length, outwards
  float intensity = 0;       ///< as the cloud's
  float weight = 0;  ///< of the views that it is the mean of: each counts cos^2 of its slant
  int views = 0;     ///< in which it was seen, less those that saw through it
};

/// Where an object stands before a camera.
struct Registration {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< the object's frame to the camera's
  std::size_t points = 0;  ///< of the object that were found in the cloud
  double share = 0;        ///< of those that should be seen at that pose
  double rms = 0;          ///< of their distances along the surface's normal, mm
};

/// Poses an object from near `guess` to a camera's organised cloud: each element, seen by the
/// camera, is compared with the point of its pixel, and the squared distances along the sum of both
/// normals are made least, round by round (iterative closest points; Rusinkiewicz 2019). Pixels
/// that look elsewhere, lie more than a few pixels' width off or differ in slope do not count. What
/// the form leaves open, as turns of a sphere, stays as guessed. At most some 10,000 elements, in
/// even steps, are looked at. `normals`: of the cloud.
Registration register_to(std::span<const ModelElement> object, const Cloud& cloud,
                         const Normals& normals, const Lens& camera,
                         const Eigen::Isometry3d& guess);

}  // namespace slipstream
