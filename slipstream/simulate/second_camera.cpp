#include "slipstream/simulate/second_camera.h"

#include <Eigen/Geometry>

#include "slipstream/simulate/named_scenes.h"

namespace slipstream {

Scanner second_scanner(const Scanner& first) {
  constexpr double past_the_projector = 1.6;
  const Eigen::Vector3d centre = past_the_projector * projector_centre(first);
  const Eigen::Vector3d forward = (working_volume(first).centre - centre).normalized();
  const Eigen::Vector3d right = Eigen::Vector3d::UnitY().cross(forward).normalized();
  Eigen::Matrix3d turn;  // from the first camera's frame to the second's
  turn << right.transpose(), forward.cross(right).transpose(), forward.transpose();

  Scanner second = first;
  second.rotation = first.rotation * turn.transpose();
  second.translation = in_projector_frame(first, centre);
  return second;
}

Scene seen_from_second(const Scene& scene, const Scanner& first, const Scanner& second) {
  const Eigen::Matrix3d turn = second.rotation.transpose() * first.rotation;
  Eigen::Isometry3d to_second = Eigen::Isometry3d::Identity();
  to_second.linear() = turn;
  to_second.translation() = second.rotation.transpose() * (first.translation - second.translation);
  Scene seen = scene;
  for (Body& body : seen) {
    body.pose = to_second * body.pose;
    body.motion.step = turn * body.motion.step;
    body.motion.turn = turn * body.motion.turn;
    body.motion.vibration.amplitude = turn * body.motion.vibration.amplitude;
    body.motion.centre = to_second * body.motion.centre;
  }
  return seen;
}

VirtualWorld seen_from_second(const VirtualWorld& first) {
  VirtualWorld second{.scanner = second_scanner(first.scanner), .photometry = first.photometry};
  second.scene = seen_from_second(first.scene, first.scanner, second.scanner);
  second.photometry.seed = ~first.photometry.seed;
  return second;
}

}  // namespace slipstream
