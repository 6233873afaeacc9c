#pragma once

#include "slipstream/codes/layout.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// How each pixel moved while a window of frames was taken that shows `K` of its patterns twice:
/// see motion_window. Kept and handed in again it is written anew without allocation.
struct FrameMotion {
  /// How far the phase moves from one frame to the next, rad, at most pi / N either way; to first
  /// order: where it moves by 0.04 rad in a cycle within 5 %, by 0.4 rad within 26 %.
  Image<float> speed;
  /// Standard deviation, grey levels of the frames, of what no such speed explains: noise where the
  /// surface moved evenly, more where an edge or paint passed. 0 for K = 1.
  Image<float> unexplained;
};

/// From frame n to n + N of one pattern, N the steps of a cycle, I_n changes by -2 B sin(N v / 2)
/// sin(phi_n - delta_n), v the speed, phi_n the phase half way, delta_n the pattern's shift: v by
/// least squares. Harmonics cancel, as both frames show the same.
class MotionMeasurement {
 public:
  /// Whether the band is a window of more than a cycle.
  static bool is_possible(const Band& window) {
    return window.cycle && window.cycle->steps < static_cast<int>(window.mean.size());
  }
  /// Only where it is possible.
  explicit MotionMeasurement(const Band& window);

  /// Of as many frames as the window has.
  void operator()(const FrameViews& frames, FrameMotion& motion) const;
  /// Share of the pixels (one in 64) of that modulation, grey levels of the frames, that move by
  /// 0.01 rad a frame and more than noise of that variance explains.
  [[nodiscard]] double moving_share(const FrameViews& frames, double least_modulation,
                                    double noise_variance) const;

 private:
  struct PixelMotion {
    float speed = 0, unexplained = 0;
    float modulation = 0;
    float evidence = 0;  ///< square of the change that the speed explains, grey levels^2
  };
  template <class Intensity>
  PixelMotion motion_at(const Intensity& I) const;

  std::size_t N_, K_;
  std::vector<float> cosine_, sine_;
  std::vector<float> cos_delta_, sin_delta_;  ///< of the patterns that are shown twice
  std::vector<float> from_middle_;            ///< of the window to half way between both, in frames
};

}  // namespace slipstream
