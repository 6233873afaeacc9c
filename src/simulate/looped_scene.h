#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "simulate/rendered_reel.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"

namespace slipstream {

/// Script of a camera while the patterns are shown `cycles` times, as a seamless loop: bodies move
/// back and forth through their position at time 0, or rotate continuously if they only turn and
/// the frames last a full turn to within half a cycle. Each frame has its own noise. Scenes that
/// begin with a body of another size, as one that breathes, do not rest. Throws Error for less than
/// one cycle.
ReelScript looped_scene(const Scanner& scanner, const Scene& scene, const PatternSet& patterns,
                        const Photometry& photometry, int cycles, FirstRest rest = FirstRest::none);

/// Script of a camera in front of a sheet that rests for `still_cycles` in each pose and moves to
/// the next within one cycle, cyclically, while the projector repeats the patterns of all sets. One
/// cycle of the last pose suffices. Throws Error for less than one pose or cycle.
ReelScript moved_board(const VirtualWorld& world, Body sheet,
                       const std::vector<Eigen::Isometry3d>& poses,
                       const std::vector<PatternSet>& sets, int still_cycles);

/// The first frame of a set; black if the set is unquantised.
Frame first_frame(const FrameSet& exposed);

}  // namespace slipstream
