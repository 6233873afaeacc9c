#include "slipstream/scan.h"

#include <utility>

#include "decode/frame_adapter.h"

namespace slipstream {

Scan merged(Scan scan) {
  scan.exposures = scan.sequence.exposures;

  // Only exposures, a second axis and multiplexed frames need any work.
  const Strategy& strategy = scan.sequence.strategy;
  if (frame_count(scan.sequence) == frame_count(strategy) && !strategy.demodulation()) return scan;

  scan.order.clear();  // it refers to the frames of all exposures and axes

  std::vector<FrameSet> frames = adapted(scan.sequence, std::move(scan.frames));
  scan.sequence = merged_sequence(std::move(scan.sequence));
  scan.frames = std::move(frames.front());

  if (frames.size() == 1) return scan;

  // Both axes: the frames along y become a scan of their own.
  scan.other_axis = {
      {.frames = std::move(frames.back()), .sequence = along(scan.sequence, Axis::y)}};
  scan.sequence = along(std::move(scan.sequence), Axis::x);
  return scan;
}

}  // namespace slipstream
