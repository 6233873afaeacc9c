#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calibrate/hand_eye_adjustment.h"
#include "calibrate/hand_eye_start.h"
#include "geometry/pose_convention.h"
#include "slipstream/finding.h"

namespace slipstream {

struct HandEyeSettings {
  EyePlace place = EyePlace::in_hand;
  /// The known parts of the robot's and the boards' convention, as for conventions_of.
  std::string robot, boards;
};

/// How far the board of a pose is from where the robot's pose predicts it.
struct HandEyeError {
  double rotation = 0;     ///< rad
  double translation = 0;  ///< mm
};

/// One pose of the robot and its board.
struct HandEyePose {
  std::string name;
  bool used = false;
  std::string reason{};                    ///< why it is not used
  std::optional<HandEyeError> error{};     ///< nullopt if its numbers are no pose
  std::optional<HandEyeError> left_out{};  ///< predicted by a calibration without it
};

/// The result's standard deviations with more poses.
struct MorePoses {
  std::string which;  ///< "15 more like these", "2 turned by 30 degrees about the tool's x"
  double rotation = 0, translation = 0;  ///< rad and mm, as of HandEye
};

struct HandEye {
  EyePlace place = EyePlace::in_hand;
  PoseConvention robot, boards;  ///< found
  HandEyePoses poses;
  /// Standard deviations of the camera's pose: about its own axes, rad, and along those of tool or
  /// base, mm. The larger of the fit's and a jackknife's over the poses.
  Eigen::Vector3d rotation_deviation, translation_deviation;
  HandEyeScatter scatter;
  std::vector<HandEyePose> each;     ///< in the order of the robot's table
  HandEyeError mean, mean_left_out;  ///< over the used poses; the latter NaN if fewer than 4
  std::vector<MorePoses> more;
  /// Size of the boards that the robot's travel measures, over the one configured.
  double scale = 1, scale_deviation = 0;
  std::vector<Finding> findings;
};

/// Most poses of a calibration.
inline constexpr std::size_t most_hand_eye_poses = 1000;

/// Finds the camera on a robot's tool, or beside the robot, from poses of the robot and, at the
/// same moments, of a board. Finds the conventions of both tables, leaves out poses that contradict
/// the others, and refines the closed form's result. Throws Error for fewer than three poses or
/// more than most_hand_eye_poses, for turns about one axis alone, if no convention or more than one
/// fits, and if fewer than three in five poses agree.
HandEye calibrate_hand_eye(PoseTable robot, PoseTable boards, const HandEyeSettings& settings);

}  // namespace slipstream
