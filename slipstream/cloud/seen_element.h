#pragma once

#include <cmath>
#include <optional>

#include <Eigen/Geometry>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/depth_step.h"
#include "slipstream/cloud/normals.h"
#include "slipstream/cloud/registration.h"
#include "slipstream/geometry/lens.h"

namespace slipstream {

inline Eigen::Vector3d normal_at(const Normals& normals, int column, int row) {
  return {normals.x(column, row), normals.y(column, row), normals.z(column, row)};
}

/// Cosine between a surface's normal and the view on it: 1 where it faces the camera.
inline double facing(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) {
  return -normal.dot(point.normalized());
}

/// An element in the camera's frame, and the point of the cloud in its pixel.
struct SeenElement {
  Eigen::Vector3d point, normal;              ///< of the element
  Eigen::Vector2d pixel;                      ///< where the camera sees it
  int column = 0, row = 0;                    ///< the nearest
  Eigen::Vector3d cloud_point, cloud_normal;  ///< NaN where there is none
};

/// None where the element is turned away, slanted too much or outside of the picture.
inline std::optional<SeenElement> seen_element(const ModelElement& element,
                                               const Eigen::Isometry3d& pose, const Cloud& cloud,
                                               const Normals& normals, const Lens& camera) {
  constexpr double least_facing = 0.3;
  SeenElement seen;
  seen.normal = pose.linear() * element.normal.cast<double>();
  seen.point = pose * element.position.cast<double>();
  if (!(seen.point.z() > 0) || facing(seen.point, seen.normal) < least_facing) return std::nullopt;
  seen.pixel = project(camera, seen.point);
  const Eigen::Vector2d nearest = seen.pixel.array().round();
  const auto [width, height] = cloud.size();
  if (!(nearest.x() >= 0 && nearest.y() >= 0 && nearest.x() < width && nearest.y() < height)) {
    return std::nullopt;
  }
  seen.column = static_cast<int>(nearest.x());
  seen.row = static_cast<int>(nearest.y());
  seen.cloud_point = position_at(cloud, seen.column, seen.row);
  seen.cloud_normal = normal_at(normals, seen.column, seen.row);
  return seen;
}

/// The distance between the rays of neighbouring pixels at a point, mm.
inline double pixel_width(const Lens& camera, const Eigen::Vector3d& point) {
  return point.z() / camera.intrinsic(0, 0);
}

}  // namespace slipstream
