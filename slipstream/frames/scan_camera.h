#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "slipstream/frames/frame.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// What was seen of whatever stands before the camera, to judge it before a scan is taken.
struct Glimpse {
  std::vector<FrameSet> frames;  ///< all together they show it without fringes
  bool still = false;            ///< as in the glimpse before
};

/// A camera and patterns before it, of which scans are taken in step. One thread uses it.
class ScanCamera {
 public:
  virtual ~ScanCamera() = default;

  /// Waits for a glimpse, `timeout` at most. None where none came. Throws WorldError where the
  /// source of frames has ended.
  virtual std::optional<Glimpse> look(std::chrono::milliseconds timeout) = 0;
  /// The frames of each scan, in pattern order, of what the last glimpse showed. None where
  /// something moved meanwhile, or a frame was lost.
  virtual std::optional<std::vector<FrameSet>> take() = 0;
};

/// Whether nothing moved from frames to others of the same patterns: fewer than one pixel of 200
/// differs by more than 16 of 255 grey levels, which noise does not and a board that moves by a
/// third of a pixel does. False where they differ in size or count.
bool is_still(const FrameViews& before, const FrameViews& after);

/// Frames of one format, one or more, as a set.
FrameSet frame_set_of(std::vector<Frame> frames);

}  // namespace slipstream
