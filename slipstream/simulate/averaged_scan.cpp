#include "slipstream/simulate/averaged_scan.h"

#include "slipstream/capture/mean_frames.h"

namespace slipstream {

FrameSet take_averaged(const VirtualScan& scan, const PatternSet& patterns, Photometry photometry,
                       int repetitions) {
  MeanFrames frames;
  for (int i = 0; i < repetitions; ++i) {
    frames.add(take_again(scan, patterns, photometry));
    ++photometry.seed;
  }
  return frames.mean();
}

}  // namespace slipstream
