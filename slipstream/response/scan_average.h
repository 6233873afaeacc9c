#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <string>

#include "slipstream/base/throw_if-inl.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scan.h"

namespace slipstream {

/// 1 where both masks are 1. Throws Error if their sizes differ.
inline Image<std::uint8_t> in_both(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  throw_if(a.size() != b.size(),
           "the scans have different sizes; expected scans of one static scene");
  Image<std::uint8_t> both = a;
  std::ranges::transform(both, b, both.begin(), std::bit_and<std::uint8_t>());
  return both;
}

/// Average of scans of one static scene.
struct ScanAverage {
  /// `name`: of the scan, for messages. Throws Error if it differs from the first in strategy, size
  /// or bits.
  void add(const Scan& scan, const std::string& name) {
    const Image<std::uint8_t> of_scan = unclipped_mask(scan.frames);
    if (frames.count() == 0) {
      first_name = name;
      sequence = scan.sequence;
      unclipped = Image<std::uint8_t>(of_scan.size(), 1);
    }
    throw_if(scan.sequence.strategy != sequence.strategy,
             "{}: strategy differs from {}; averaged scans must match", name, first_name);
    frames.add(scan.frames);
    unclipped = in_both(unclipped, of_scan);
  }

  std::string first_name;
  Sequence sequence;  ///< of the first scan
  MeanFrames frames;
  Image<std::uint8_t> unclipped;  ///< 1 where no frame is at either end of the grey levels
};

}  // namespace slipstream
