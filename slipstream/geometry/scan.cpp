#include "slipstream/geometry/scan.h"

#include <utility>

#include "slipstream/decode/frame_adapter.h"

namespace slipstream {

Scan merged(Scan scan) {
  scan.exposures = scan.sequence.exposures;
  if (!needs_adapting(scan.sequence)) return scan;
  scan.order.clear();  // which is of the frames of all exposures and axes
  std::vector<FrameSet> frames = adapted(scan.sequence, std::move(scan.frames));
  scan.sequence = merged_sequence(std::move(scan.sequence));
  scan.frames = std::move(frames.front());
  if (frames.size() == 1) return scan;
  scan.other_axis = {
      {.frames = std::move(frames.back()), .sequence = along(scan.sequence, Axis::y)}};
  scan.sequence = along(std::move(scan.sequence), Axis::x);
  return scan;
}

}  // namespace slipstream
