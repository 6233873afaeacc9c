#pragma once

#include <cstdint>
#include <string>

#include "slipstream/frame_set.h"
#include "slipstream/scan.h"

namespace slipstream {

/// 1 where both masks are 1. Throws Error if their sizes differ.
Image<std::uint8_t> in_both(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b);

/// Average of scans of one static scene.
struct ScanAverage {
  /// `name`: of the scan, for messages. Throws Error if it differs from the first in strategy, size
  /// or bits.
  void add(const Scan& scan, const std::string& name);

  std::string first_name;
  Sequence sequence;  ///< of the first scan
  MeanFrames frames;
  Image<std::uint8_t> unclipped;  ///< 1 where no frame is at either end of the grey levels
};

}  // namespace slipstream
