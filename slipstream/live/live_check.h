#pragma once

#include <vector>

#include "slipstream/capture/frame_views.h"
#include "slipstream/check/finding.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/image/size.h"
#include "slipstream/strategy/sequence.h"

namespace slipstream {

/// Whether the frames of a live scan still fit their patterns, the scanner and each other, by a few
/// of their pixels: cheap enough for every cycle. One thread uses it.
class LiveCheck {
 public:
  LiveCheck(const Sequence& sequence, const Scanner& scanner, Size camera);

  /// What is amiss with these frames, which are in pattern order and of the camera's size. Nothing
  /// is allocated where nothing is.
  std::vector<Finding> look(const FrameViews& window);
};

}  // namespace slipstream
