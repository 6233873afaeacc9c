#pragma once

#include "slipstream/scene.h"

namespace slipstream {

/// Frames in which a hand's motion repeats: 2 s at 120 frames per second.
inline constexpr double hand_period = 240;

/// A left hand with its palm to the viewer, about 1 high, centred on the origin, Y up, facing +Z,
/// scaled by `size` and moved by `pose`, its frame to the camera's. Each phalanx is a body of its
/// own and turns about its joint and moves with the one that carries it: the fingers bend and
/// stretch while the thumb moves faster and the wrist turns and moves to and fro.
Scene hand(double size, const Eigen::Isometry3d& pose);

}  // namespace slipstream
