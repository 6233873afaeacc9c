#include "slipstream/scan/scan.h"

#include <utility>

#include "slipstream/capture/merged_exposures.h"

namespace slipstream {

Scan merged(Scan scan) {
  scan.exposures = scan.sequence.exposures;
  if (scan.sequence.exposures.size() == 1) return scan;
  scan.order.clear();  // which is of the frames of all exposures
  scan.frames = merged_exposures(scan.frames, scan.sequence.exposures);
  scan.sequence = merged_sequence(std::move(scan.sequence));
  return scan;
}

}  // namespace slipstream
