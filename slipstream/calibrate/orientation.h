#pragma once

#include "slipstream/calibrate/board_view.h"

namespace slipstream {

/// Throws Error, naming the pose, where camera and projector see the board mirrored to each other:
/// a projector or camera picture is mirrored, or the scan along x was taken for that along y. Seen
/// from the same side of the board, two devices differ by a turn, never by a reflection.
void require_same_handedness(const BoardView& view);

}  // namespace slipstream
