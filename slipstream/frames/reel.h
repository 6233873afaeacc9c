#pragma once

#include <cstddef>
#include <vector>

#include "slipstream/frames/frame.h"

namespace slipstream {

/// Frames that a camera gives over and over, each as often as `order` names it.
struct Reel {
  std::vector<Frame> frames;
  std::vector<std::size_t> order;  ///< which of the frames comes when
  std::size_t enough = 0;  ///< frames by which all of it was seen; 0: as many as in the order
};

/// Each frame once, one after the other.
Reel reel_of(std::vector<Frame> frames);

}  // namespace slipstream
