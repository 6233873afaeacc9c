#pragma once

#include <span>

#include <Eigen/Geometry>

namespace slipstream {

/// Where the camera is: on the robot's tool, or fixed beside the robot, whose tool then carries the
/// board.
enum class EyePlace { in_hand, to_hand };

/// Robot and board at the same time, mm.
struct PosePair {
  Eigen::Isometry3d robot;  ///< tool to base
  Eigen::Isometry3d board;  ///< board to camera
};

/// The two unknown poses of a hand-eye calibration, mm.
struct HandEyePoses {
  Eigen::Isometry3d camera = Eigen::Isometry3d::Identity();  ///< camera to tool, or to base
  Eigen::Isometry3d board = Eigen::Isometry3d::Identity();   ///< board to base, or to tool
};

/// Rotation, rad, then translation, mm.
using PoseError = Eigen::Matrix<double, 6, 1>;

/// Standard deviations of single poses: of the robot at its tool, and of the board in the camera's
/// frame, whose distance and tilt are less certain than the rest.
struct HandEyeScatter {
  double robot_rotation = 0;     ///< rad, about each axis
  double robot_translation = 0;  ///< mm, along each axis
  double board_tilt = 0;         ///< rad, about the camera's x and y
  double board_roll = 0;         ///< rad, about the optical axis
  double board_across = 0;       ///< mm, along the camera's x and y
  double board_depth = 0;        ///< mm, along the optical axis
};

/// The derivatives of a pair's error by the camera's pose, then by the board's, each turned and
/// moved in its own frame.
using PairDerivatives = Eigen::Matrix<double, 6, 12>;

struct AdjustedHandEye {
  HandEyePoses poses;
  /// Covariance of the camera's pose and the board's: rotation in its own frame, translation in the
  /// other's.
  Eigen::Matrix<double, 12, 12> covariance;
  HandEyeScatter scatter;
};

/// The pose of the robot at which the board appears so.
Eigen::Isometry3d robot_for(const Eigen::Isometry3d& board, const HandEyePoses& poses,
                            EyePlace place);

/// Board as measured less as predicted, in the camera's frame.
PoseError error_of(const PosePair& pair, const HandEyePoses& poses, EyePlace place);

PairDerivatives derivatives_of(const PosePair& pair, const HandEyePoses& poses, EyePlace place);

/// Covariance of error_of a pair for poses that scatter so.
Eigen::Matrix<double, 6, 6> covariance_of(const PosePair& pair, const HandEyePoses& poses,
                                          EyePlace place, const HandEyeScatter& scatter);

/// Minimises the errors of all pairs over both unknown poses, with Huber's loss and each error in
/// units of its covariance. The scatter is estimated with them by expectation maximisation: the
/// error of a pair is the sum of the robot's, carried to the board, and the camera's. Throws Error
/// if the pairs do not determine the poses.
AdjustedHandEye adjusted_hand_eye(std::span<const PosePair> pairs, const HandEyePoses& start,
                                  EyePlace place);

}  // namespace slipstream
