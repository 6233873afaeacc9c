// Clouds of an object that turns before the virtual camera, as depth and noise alone make them.
#pragma once

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/geometry/lens.h"
#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/seen_scene.h"

namespace slipstream {

/// A box with spheres and another box on it, that turns by a degree from view to view.
inline Scene turning_object(const Scanner& scanner) {
  const Eigen::Vector3d middle = working_volume(scanner).centre;
  const auto at = [&](double x, double y, double z) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(middle + Eigen::Vector3d(x, y, z));
    pose.rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 0.5).normalized()));
    return pose;
  };
  Scene scene{Body{.shape = Box{{90, 150, 60}}, .pose = at(0, 0, 0)},
              Body{.shape = Sphere{35}, .pose = at(30, -60, -20)},
              Body{.shape = Sphere{28}, .pose = at(-25, 20, 30)},
              Body{.shape = Sphere{22}, .pose = at(-35, 60, -30)},
              Body{.shape = Box{{50, 40, 70}}, .pose = at(35, 50, 15)}};
  for (Body& body : scene) {
    body.motion = {.turn = {0, std::numbers::pi / 180, 0}, .centre = middle};
  }
  return scene;
}

class DepthCamera {
 public:
  DepthCamera(Scanner scanner, double sigma) : scanner_(std::move(scanner)), noise_(0, sigma) {
    const Size size = scanner_.camera.size;
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        rays_.push_back(ray_through(scanner_.camera, {column, row}));
      }
    }
  }

  Cloud see(const Scene& scene, double time) {
    const SeenScene seen = look(scanner_, scene, {}, time);
    Cloud cloud(scanner_.camera.size);
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      if (std::isnan(seen.lit_column.begin()[i])) continue;  // no surface, or in shadow
      const Eigen::Vector3d point = (seen.depth.begin()[i] + noise_(random_)) * rays_[i];
      cloud.x.begin()[i] = static_cast<float>(point.x());
      cloud.y.begin()[i] = static_cast<float>(point.y());
      cloud.z.begin()[i] = static_cast<float>(point.z());
      cloud.validity.begin()[i] = Validity::valid;
    }
    return cloud;
  }

 private:
  Scanner scanner_;
  std::normal_distribution<double> noise_;
  std::mt19937 random_{1};
  std::vector<Eigen::Vector3d> rays_;
};

}  // namespace slipstream
