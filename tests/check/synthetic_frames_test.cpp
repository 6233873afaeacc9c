// Evidence in frames without a scene: pixels whose levels follow from an equation.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "check/code_evidence.h"
#include "check/damaged_frames.h"
#include "check/fit.h"
#include "check/frame_faults.h"
#include "check/method_limits.h"
#include "check/phase_noise.h"
#include "check/waveform.h"
#include "check/wrapped_levels.h"
#include "slipstream/strategy.h"

namespace slipstream::synthetic_frames_test {

constexpr Size size{320, 240};

/// The level of frame n at a pixel.
using Level = std::function<double(int n, int column, int row)>;

/// Pictures of these levels, with the model of their patterns.
struct Frames {
  template <class Pixel = std::uint8_t>
  static ScanSamples samples_of(int count, const Level& level, int bits, double least_range) {
    std::vector<Image<Pixel>> pictures(static_cast<std::size_t>(count), Image<Pixel>(size));
    for (int n = 0; n < count; ++n) {
      for_each_pixel_in_order(size, [&](int column, int row) {
        pictures[static_cast<std::size_t>(n)](column, row) =
            static_cast<Pixel>(std::lround(level(n, column, row)));
      });
    }

    ScanSamples samples(size, count);
    samples.take(FrameSet(std::move(pictures), bits), {.least_range = least_range});
    return samples;
  }
};

/// The column as a coordinate: each camera pixel sees one projector pixel.
double along(double column) {
  return column / size.width;
}

Sequence sequence_of(const Strategy& strategy) {
  return {.strategy = strategy, .projector = size};
}

}  // namespace slipstream::synthetic_frames_test
