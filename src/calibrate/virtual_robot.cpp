#include "calibrate/virtual_robot.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "base/throw_if-inl.h"
#include "calibrate/first_guess.h"
#include "geometry/rotation.h"
#include "slipstream/board_capture.h"
#include "slipstream/calibration_board.h"

namespace slipstream {
namespace {

class RobotChance {
 public:
  explicit RobotChance(std::uint32_t seed) : random_(seed) {}

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  /// Three independent Gaussian numbers.
  Eigen::Vector3d scattered(double deviation) {
    const double x = gauss_(random_), y = gauss_(random_), z = gauss_(random_);
    return deviation * Eigen::Vector3d(x, y, z);
  }

  /// A direction in the plane of x and y.
  Eigen::Vector3d direction() {
    const double angle = between(0, two_pi);
    return {std::cos(angle), std::sin(angle), 0};
  }

 private:
  std::mt19937 random_;
  std::normal_distribution<double> gauss_;
};

Lens robot_camera() {
  Lens lens;
  lens.size = {1280, 1024};
  lens.intrinsic << 1500, 0, 640, 0, 1500, 512, 0, 0, 1;
  return lens;
}

/// A board that the camera sees whole, turned and tilted.
Eigen::Isometry3d board_pose(const VirtualRobot& robot, const BoardPlaces& places,
                             RobotChance& chance) {
  const double tilt = robot.tilt * std::sqrt(chance.between(0, 1));
  const Eigen::AngleAxisd tilted(tilt, chance.direction());
  const Eigen::AngleAxisd rolled(chance.between(-90, 90) * degree, Eigen::Vector3d::UnitZ());

  const double x = chance.between(-50, 50), y = chance.between(-40, 40);
  const Eigen::Vector3d centre(x, y, chance.between(420, 600));
  const Eigen::Matrix3d rotation = (tilted * rolled).toRotationMatrix();
  const Eigen::Vector3d middle = 0.5 * (places.front() + places.back());
  return pose_from(rotation, centre - rotation * middle);
}

/// The board's pose as the camera finds it.
Eigen::Isometry3d measured_board(const Eigen::Isometry3d& board, const BoardPlaces& places,
                                 double pixel_error, RobotChance& chance) {
  const Lens lens = robot_camera();
  BoardView view{.name = "virtual", .places = {}, .camera = {}, .projector = {}};
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::Vector3d seen = lens.intrinsic * (board * places[i]);
    view.places.push_back(static_cast<int>(i));
    view.camera.emplace_back(seen.head<2>() / seen.z() + chance.scattered(pixel_error).head<2>());
  }
  return pose_before_camera(view, lens, places);
}

HandEyePoses random_rig(EyePlace place, RobotChance& chance) {
  const Eigen::Quaterniond any(Eigen::AngleAxisd(chance.between(0, 2), chance.direction()) *
                               Eigen::AngleAxisd(chance.between(-3, 3), Eigen::Vector3d::UnitZ()));
  const Eigen::Matrix3d near = (Eigen::AngleAxisd(chance.between(0, 0.6), chance.direction()) *
                                Eigen::AngleAxisd(chance.between(-3, 3), Eigen::Vector3d::UnitZ()))
                                   .toRotationMatrix();

  const Eigen::Vector3d beside = chance.scattered(70) + Eigen::Vector3d(0, 0, 60);
  const Eigen::Vector3d away =
      chance.scattered(80) + Eigen::Vector3d(chance.between(350, 700), 0, 150);

  // On the tool something is near and roughly along it; in the base it is anywhere.
  const Eigen::Isometry3d on_tool = pose_from(near, beside);
  const Eigen::Isometry3d in_base = pose_from(any.toRotationMatrix(), away);
  if (place == EyePlace::in_hand) return {.camera = on_tool, .board = in_base};
  return {.camera = in_base, .board = on_tool};
}

}  // namespace

RobotRun moved_robot(const VirtualRobot& robot) {
  throw_if(robot.poses < 1 || robot.poses > 1000, "{} poses; expected 1 to 1000", robot.poses);
  RobotChance chance(robot.seed);
  const BoardPlaces places = printed_places({.columns = 13, .rows = 9, .spacing = 15});

  RobotRun run;
  run.truth = random_rig(robot.place, chance);
  const Eigen::Isometry3d &camera = run.truth.camera, &on = run.truth.board;

  for (int i = 0; i < robot.poses; ++i) {
    const Eigen::Isometry3d board = board_pose(robot, places, chance);
    const Eigen::Isometry3d tool = robot.place == EyePlace::in_hand
                                       ? on * board.inverse() * camera.inverse()
                                       : camera * board * on.inverse();

    // The robot stands a little beside where it says.
    const Eigen::Matrix3d turn = rotation_of_vector(chance.scattered(robot.rotation_error));
    const Eigen::Isometry3d reported =
        tool * pose_from(turn, chance.scattered(robot.translation_error));
    run.pairs.push_back({reported, measured_board(board, places, robot.pixel_error, chance)});
  }
  return run;
}

PoseTable table_of(const std::vector<Eigen::Isometry3d>& poses, const PoseConvention& convention) {
  PoseTable table;
  for (const Eigen::Isometry3d& pose : poses) {
    Eigen::Isometry3d written = convention.inverse ? pose.inverse() : pose;
    written.translation() /= convention.unit;
    table.rows.push_back(row_of(written, convention.rotation));
  }
  return table;
}

}  // namespace slipstream
