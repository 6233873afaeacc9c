#pragma once

#include <span>
#include <vector>

#include "calibrate/hand_eye_adjustment.h"
#include "geometry/pose_convention.h"

namespace slipstream {

/// A closed-form hand-eye calibration with one reading of the numbers.
struct HandEyeStart {
  PoseConvention robot, board;
  HandEyePoses poses;  ///< mm
  /// Median over the poses, rad: rotation error and translation error over the board's distance.
  double misfit = 0;
};

/// The frames between which a table's poses are, if not inverse.
inline constexpr PoseFrames robot_frames{"tool", "base"}, board_frames{"board", "camera"};

/// Tries all combinations of the conventions, and returns those that fit the poses about as well as
/// the best, best first; more than one only if they give another hand-eye pose. Up to half of the
/// poses may be wrong. Row i of both tables is the same moment. Of readings that no pose can tell
/// apart, takes those with the board in front of the camera and, unless the units are known, 30 mm
/// to 30 m away. Throws Error if there are none, and for fewer than three usable rows.
std::vector<HandEyeStart> fitting_conventions(const PoseTable& robot,
                                              std::span<const PoseConvention> robot_conventions,
                                              const PoseTable& boards,
                                              std::span<const PoseConvention> board_conventions,
                                              EyePlace place);

}  // namespace slipstream
