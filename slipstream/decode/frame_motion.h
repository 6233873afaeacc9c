#pragma once

#include <cstddef>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/layout.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// How each pixel moved while a window of frames was taken that shows `K` of its patterns twice:
/// see motion_window. Kept and handed in again it is written anew without allocation.
struct FrameMotion {
  /// How far the phase moves from one frame to the next, rad, at most pi / N either way; to first
  /// order: where it moves by 0.04 rad in a cycle within 5 %, by 0.4 rad within 26 %.
  Image<float> speed;
  /// Standard deviation of a frame that would explain what no such speed does between frames of one
  /// pattern, grey levels of the frames: noise alone where the surface moved evenly, more where an
  /// edge or paint passed. 0 for K = 1, which leaves nothing to be compared.
  Image<float> unexplained;
};

/// From frame n to frame n + N of one pattern, N the steps of a cycle, I_n changes by
/// -2 B sin(N v / 2) sin(phi_n - delta_n), v the speed, phi_n the phase half way between them and
/// delta_n the pattern's shift: the v of least squares. No harmonic of the pattern disturbs it, as
/// both frames show the same.
class MotionMeasurement {
 public:
  /// Whether the band is a window of more than a cycle.
  static bool is_possible(const Band& window);
  /// Only where it is possible.
  explicit MotionMeasurement(const Band& window);

  /// Of as many frames as the window has.
  void operator()(const FrameViews& frames, FrameMotion& motion) const;
  /// Of the pixels that have that modulation, grey levels of the frames, one in 64 looked at, the
  /// share whose phase moves: by 0.01 rad from frame to frame, and by what noise of that variance
  /// rarely makes.
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
