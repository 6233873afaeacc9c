#pragma once

#include <string>
#include <vector>

#include "slipstream/check/frame_model.h"
#include "slipstream/codes/layout.h"

namespace slipstream {

/// A way in which frames come to stand in another order than the patterns were shown.
struct MistakenOrder {
  enum class Kind {
    usual,
    slipped,      ///< the whole cycle begins at another frame
    far_fetched,  ///< two frames far apart exchanged
  };
  FrameOrder order;   ///< that sets it right: frame `order[n]` shows pattern n
  std::string words;  ///< "frames 0 to 2 look rotated by 1"
  Kind kind = Kind::usual;
};

/// The usual ones for a layout, the simplest first: begun at another frame, runs of steps rotated,
/// reversed or swapped, runs shown in turns, two frames exchanged.
std::vector<MistakenOrder> mistaken_orders(const Layout& layout);

/// The one order that does what `first` does, nothing where it is empty, and then `then`.
FrameOrder composed(const FrameOrder& first, const FrameOrder& then);

/// "2,0,1,3,4,5".
std::string text_of(const FrameOrder& order);

}  // namespace slipstream
