#pragma once

#include <vector>

#include "slipstream/capture/frame.h"
#include "slipstream/capture/frame_set.h"
#include "slipstream/capture/pool.h"

namespace slipstream {

/// The frames of a window, which are of one format, as a set, copied; empty where there are none.
FrameSet frame_set_of(const std::vector<Pooled<Frame>>& window);

}  // namespace slipstream
