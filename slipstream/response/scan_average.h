#pragma once

#include <cstdint>
#include <string>

#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scan.h"

namespace slipstream {

/// 1 where two masks are. Throws Error where their sizes differ.
Image<std::uint8_t> in_both(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b);

/// Scans of one unmoved scene, averaged as they come.
struct ScanAverage {
  /// `name`: what a message calls the scan. Throws Error where it differs from the first in
  /// strategy, size or bits.
  void add(const Scan& scan, const std::string& name);

  std::string first_name;
  Sequence sequence;  ///< of the first scan
  MeanFrames frames;
  Image<std::uint8_t> unclipped;  ///< 1 where no frame of any is at either end of the grey levels
};

}  // namespace slipstream
