#include "simulate/turned_scene.h"

#include <Eigen/Geometry>

#include "base/numbers.h"
#include "slipstream/named_scenes.h"

namespace slipstream {

TurnAxis turntable_axis(const Scanner& scanner) {
  constexpr double looks_down = 12 * degree;
  const Eigen::Vector3d up = -Eigen::Vector3d::UnitY();
  return {Eigen::AngleAxisd(looks_down, Eigen::Vector3d::UnitX()) * up,
          working_volume(scanner).centre};
}

Scene turned_scene(const Scene& scene, const Scanner& scanner, double angle) {
  const TurnAxis axis = turntable_axis(scanner);
  const Eigen::Isometry3d turn = Eigen::Translation3d(axis.point) *
                                 Eigen::AngleAxisd(angle, axis.direction) *
                                 Eigen::Translation3d(-axis.point);

  Scene turned;
  for (Body body : scene) {
    if (body.fixed) continue;
    body.pose = turn * body.pose;
    body.motion = moved_by(turn, body.motion);
    turned.push_back(body);
  }
  return turned;
}

}  // namespace slipstream
