#include "slipstream/geometry/scan.h"

#include <utility>

#include "slipstream/decode/demodulator.h"
#include "slipstream/frames/merged_exposures.h"

namespace slipstream {

Scan merged(Scan scan) {
  scan.exposures = scan.sequence.exposures;
  const auto demodulation = scan.sequence.strategy.demodulation();
  if (frame_count(scan.sequence) == frame_count(scan.sequence.strategy) && !demodulation) {
    return scan;
  }
  scan.order.clear();  // which is of the frames of all exposures and axes
  if (scan.exposures.size() > 1) scan.frames = merged_exposures(scan.frames, scan.exposures);
  scan.sequence = merged_sequence(std::move(scan.sequence));
  if (!scan.sequence.both_axes) {
    if (demodulation) scan.frames = demodulated(*demodulation, scan.sequence.axis, scan.frames);
    return scan;
  }
  auto [first, second] = halves(std::move(scan.frames));
  if (demodulation) {
    first = demodulated(*demodulation, Axis::x, first);
    second = demodulated(*demodulation, Axis::y, second);
  }
  scan.other_axis = {{.frames = std::move(second), .sequence = along(scan.sequence, Axis::y)}};
  scan.frames = std::move(first);
  scan.sequence = along(std::move(scan.sequence), Axis::x);
  return scan;
}

}  // namespace slipstream
