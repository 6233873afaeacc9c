#pragma once

#include <cstdint>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// What the simulations of Chapter 3 assume of every pixel.
struct NoisyPixels {
  double alpha = 0.5;
  double beta = -7;              ///< ambient light, grey levels
  double noise_variance = 1.55;  ///< sigma_w^2, grey levels^2
};

/// Frames of the patterns as the camera sees them where the projector coordinate is `y`: Liu 2010,
/// Eqs. (3.2) and (3.10), Gaussian noise, not quantised.
FrameSet noisy_frames(const PatternSet& patterns, const Image<double>& y, const NoisyPixels& pixels,
                      std::uint64_t seed);

}  // namespace slipstream
