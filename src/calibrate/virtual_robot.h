#pragma once

#include <cstdint>
#include <vector>

#include "base/numbers.h"
#include "calibrate/hand_eye_adjustment.h"
#include "geometry/pose_convention.h"

namespace slipstream {

/// A robot with a camera that looks at a board, to rehearse hand-eye calibration. All errors are
/// Gaussian.
struct VirtualRobot {
  EyePlace place = EyePlace::in_hand;
  int poses = 15;
  double rotation_error = 0.01 * degree;  ///< of each reported robot pose, about each axis, rad
  double translation_error = 0.1;         ///< along each axis, mm
  double pixel_error = 0.1;               ///< of the board's corners, along each axis
  double tilt = 40 * degree;              ///< largest angle of the board to the picture, rad
  std::uint32_t seed = 1;                 ///< of the rig, the poses and their errors
};

/// Poses as robot and camera report them, and the truth.
struct RobotRun {
  HandEyePoses truth;
  std::vector<PosePair> pairs;
};

/// Moves the robot over the board. Throws Error for fewer than one or more than 1000 poses.
RobotRun moved_robot(const VirtualRobot& robot);

/// The poses as numbers in this convention.
PoseTable table_of(const std::vector<Eigen::Isometry3d>& poses, const PoseConvention& convention);

}  // namespace slipstream
