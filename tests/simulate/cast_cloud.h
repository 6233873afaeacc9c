#pragma once

#include <functional>

#include "slipstream/cloud.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scanner.h"
#include "slipstream/scene.h"

namespace slipstream {

/// What a camera at the origin would measure of a scene without any error, each point moved away
/// along its ray by `error(column, row)` mm.
inline Cloud cast_cloud(
    const Scene& scene, Size size = {320, 240},
    const std::function<double(int, int)>& error = [](int, int) { return 0.0; }) {
  const Lens camera = example_scanner(size).camera;
  Cloud cloud(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const Eigen::Vector3d ray = ray_through(camera, Eigen::Vector2d(column, row));
      const auto surface = first_surface(placed_at(scene, 0), {Eigen::Vector3d::Zero(), ray});
      if (!surface) continue;
      const Eigen::Vector3d point = surface->point + error(column, row) * ray.normalized();
      cloud.x(column, row) = static_cast<float>(point.x());
      cloud.y(column, row) = static_cast<float>(point.y());
      cloud.z(column, row) = static_cast<float>(point.z());
      cloud.validity(column, row) = Validity::valid;
    }
  }
  return cloud;
}

inline Body sphere_at(const Eigen::Vector3d& centre, double radius) {
  return {.shape = Sphere{radius}, .pose = Eigen::Isometry3d(Eigen::Translation3d(centre))};
}

}  // namespace slipstream
