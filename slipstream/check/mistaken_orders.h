#pragma once

#include <string>
#include <vector>

#include "slipstream/check/frame_evidence.h"
#include "slipstream/pattern/layout.h"

namespace slipstream {

/// A way in which frames come to stand in another order than the patterns were shown.
struct MistakenOrder {
  FrameOrder order;      ///< that sets it right: frame `order[n]` shows pattern n
  std::string words;     ///< "the frames begin 2 places late"
  bool slipped = false;  ///< the whole cycle begins at another frame
};

/// The usual ones for a layout, the simplest first: begun at another frame, runs of steps rotated,
/// reversed or swapped, runs shown in turns, two frames exchanged.
std::vector<MistakenOrder> mistaken_orders(const Layout& layout);

/// "2,0,1,3,4,5".
std::string text_of(const FrameOrder& order);

}  // namespace slipstream
