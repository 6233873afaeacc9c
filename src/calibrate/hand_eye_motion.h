#pragma once

#include <span>
#include <vector>

#include "base/numbers.h"
#include "calibrate/hand_eye.h"

namespace slipstream {

/// How much the tool turned, in its own frame.
struct TurnSpread {
  /// RMS turns about three perpendicular axes, rad, largest first.
  Eigen::Vector3d turns;
  Eigen::Matrix3d axes;  ///< in columns
};

TurnSpread turn_spread(std::span<const PosePair> pairs);

/// Below this the turns about a second axis do not determine the result at all, rad.
inline constexpr double least_second_turn = 2 * degree;

/// "x", "y" or "z": the tool's axis nearest to that about which it should turn more.
char weakest_axis(const TurnSpread& spread);

/// A warning if the tool turned little about a second axis.
std::vector<Finding> findings_of_motion(const TurnSpread& spread);

/// What twice the poses, and what two more turned about each of the tool's axes would give.
std::vector<MorePoses> more_poses(std::span<const PosePair> pairs, const AdjustedHandEye& fit,
                                  EyePlace place);

}  // namespace slipstream
