#include "tools/reproduce/noisy_frames.h"

#include <cmath>
#include <random>
#include <utility>

namespace slipstream {

FrameSet noisy_frames(const PatternSet& patterns, const Image<double>& y, const NoisyPixels& pixels,
                      std::uint64_t seed) {
  const auto& [alpha, beta, noise_variance] = pixels;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> w(0, std::sqrt(noise_variance));
  FrameSet::ImagesUnquantised frames;
  for (int n = 0; n < patterns.count; ++n) {
    Image<double>& frame = frames.emplace_back(y.size());
    for (std::size_t i = 0; i < y.pixel_count(); ++i) {
      frame.begin()[i] = alpha * (patterns.intensity(n, y.begin()[i]) + beta) + beta + w(random);
    }
  }
  return FrameSet(std::move(frames));
}

}  // namespace slipstream
