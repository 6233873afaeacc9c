#pragma once

#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/frames/frame.h"
#include "slipstream/frames/pool.h"

namespace slipstream {

/// The cloud of one window of frames, with what it was made from.
struct LiveCloud {
  Cloud cloud;               ///< empty where no scanner is known
  ValidityCounts cleaned{};  ///< how many points cleaning took, by reason
  /// The window, as PatternWindows gives it, each frame still as the camera gave it.
  std::vector<Pooled<Frame>> frames;
  int first_pattern = 0;  ///< of its first frame
  int motion = 0;         ///< frames beyond a cycle that the cloud was made of: see motion_window
  FrameStamp newest;      ///< of the frame that completed the window
};

}  // namespace slipstream
