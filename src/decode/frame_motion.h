#pragma once

#include "decode/motion_block.h"
#include "slipstream/frame_set.h"
#include "slipstream/layout.h"

namespace slipstream {

/// Motion of each pixel during a window of frames that shows `K` of its patterns twice: see
/// motion_window. Pass it in again to reuse its memory.
struct FrameMotion {
  /// Phase change per frame, rad, at most pi / N either way; to first order: within 5 % at 0.04 rad
  /// per cycle, within 26 % at 0.4 rad.
  Image<float> speed;
  /// Standard deviation, grey levels of the frames, of the residual: noise where the surface moved
  /// evenly, more where an edge or paint passed. 0 for K = 1.
  Image<float> unexplained;
};

/// From frame n to n + N of one pattern, N the steps of a cycle, I_n changes by -2 B sin(N v / 2)
/// sin(phi_n - delta_n), v the speed, phi_n the phase half way, delta_n the pattern's shift: v by
/// least squares. Harmonics cancel, as both frames show the same pattern.
class MotionMeasurement {
 public:
  /// Whether the band is a window longer than a cycle.
  static bool is_possible(const Band& window) {
    return window.cycle && window.cycle->steps < static_cast<int>(window.mean.size());
  }

  /// Requires is_possible(window).
  explicit MotionMeasurement(const Band& window);

  /// `frames`: as many as the window has.
  void operator()(const FrameViews& frames, FrameMotion& motion) const;
  /// Share of pixels (one in 64 is sampled) with at least that modulation, grey levels of the
  /// frames, that move by 0.01 rad a frame and more than `noise_variance` explains.
  [[nodiscard]] double moving_share(const FrameViews& frames, double least_modulation,
                                    double noise_variance) const;

 private:
  MotionWeights weights_;
};

}  // namespace slipstream
