#pragma once

#include <array>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

#include "slipstream/scanner.h"

namespace slipstream {

/// A camera and a projector of random lenses that look at one place 300 to 1500 mm away from 50 to
/// 400 mm apart.
inline Scanner random_scanner(unsigned seed, double distortion = 0, Size camera = {640, 480}) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto lens = [&](Size size) {
    Lens made;
    const double focal = uniform(0.8, 2.5) * size.width;
    made.intrinsic << focal, uniform(-1, 1), size.width * uniform(0.4, 0.6), 0,
        focal * uniform(0.98, 1.02), size.height * uniform(0.4, 0.6), 0, 0, 1;
    std::array<double, 5> bend{};
    for (double& k : bend) k = distortion * uniform(-1, 1);
    bend[2] *= 0.02;
    bend[3] *= 0.02;
    made.distortion = make_distortion(bend);
    made.size = size;
    return made;
  };
  Scanner scanner;
  scanner.camera = lens(camera);
  scanner.projector = lens({1024, 768});
  const double distance = uniform(300, 1500);
  const double around = uniform(0, 2 * std::numbers::pi);
  // One by one: compilers evaluate arguments in different orders.
  Eigen::Vector3d centre, target;
  centre.z() = uniform(-30, 30);
  centre.y() = uniform(50, 400) * std::sin(around);
  centre.x() = uniform(50, 400) * std::cos(around);
  target.z() = distance;
  target.y() = uniform(-30, 30);
  target.x() = uniform(-30, 30);
  const Eigen::Vector3d forward = (target - centre).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(forward).normalized();
  Eigen::Matrix3d rotation;
  rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  scanner.rotation =
      Eigen::AngleAxisd(uniform(-0.3, 0.3), Eigen::Vector3d::UnitZ()).toRotationMatrix() * rotation;
  scanner.translation = -scanner.rotation * centre;
  return scanner;
}

}  // namespace slipstream
