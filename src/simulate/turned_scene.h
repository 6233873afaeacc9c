#pragma once

#include <Eigen/Core>

#include "slipstream/scanner.h"
#include "slipstream/scene.h"

namespace slipstream {

/// The axis of the virtual turntable, camera frame: upwards through the middle of the scanner's
/// working volume, before a camera that looks down a little.
struct TurnAxis {
  Eigen::Vector3d direction;  ///< unit length
  Eigen::Vector3d point;      ///< mm
};

TurnAxis turntable_axis(const Scanner& scanner);

/// The scene on the turntable, turned by `angle` (rad, by the right-hand rule). Fixed bodies, such
/// as a wall, would stay: they are left out.
Scene turned_scene(const Scene& scene, const Scanner& scanner, double angle);

}  // namespace slipstream
