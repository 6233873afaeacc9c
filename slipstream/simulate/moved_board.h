#pragma once

#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/frames/reel.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// What a camera sees of a sheet that somebody holds still for `still_cycles` in each pose and
/// moves on within one, while a projector shows the patterns of all sets, one set after the other,
/// over and over: the last pose is followed by the first. One cycle of the last pose is enough of
/// it. Of a pose each frame is rendered once. `rendered` is called after each pose. Throws Error
/// for less than one pose or cycle, and as virtual_frames.
Reel moved_board(const VirtualWorld& world, Body sheet, const std::vector<Eigen::Isometry3d>& poses,
                 const std::vector<PatternSet>& sets, int still_cycles,
                 const std::function<void()>& rendered);

}  // namespace slipstream
