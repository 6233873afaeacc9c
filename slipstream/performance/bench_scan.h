#pragma once

#include "slipstream/capture/frame_set.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream {

/// A scan to time on: a scanner and 8-bit frames.
struct BenchScan {
  Scanner scanner;
  FrameSet frames;
};

/// Ambient light of the scans, grey levels.
inline constexpr double bench_ambient = 5;

/// What the virtual scanner sees of a statue before a wall, 640x480, with ambient light and noise,
/// stripes along x.
BenchScan bench_scan(const Strategy& strategy);

/// Each pixel k x k pixels of a camera of k times the width and height: the same scene and geometry
/// without hours of rendering.
BenchScan enlarged(const BenchScan& scan, int k);

}  // namespace slipstream
