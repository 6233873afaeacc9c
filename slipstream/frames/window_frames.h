#pragma once

#include <vector>

#include "slipstream/frames/frame.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/pool.h"

namespace slipstream {

/// The frames of a window, which are of one format, as they stand, into `views`, whose memory is
/// used.
void view_window(const std::vector<Pooled<Frame>>& window, FrameViews& views);

/// The same; valid as long as the window's shares are.
FrameViews views_of(const std::vector<Pooled<Frame>>& window);

/// The cycle in the middle of a window of `extra` frames more, in pattern order; `first_pattern`:
/// of the window's first frame.
FrameViews middle_cycle(const FrameViews& window, int first_pattern, int extra);

}  // namespace slipstream
