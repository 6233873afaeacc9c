#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace slipstream {

/// Pixels whose motion is measured together.
inline constexpr std::size_t motion_block_pixels = 64;

/// What MotionMeasurement knows of a window whose first K patterns are shown twice.
struct MotionWeights {
  std::size_t cycle = 0;                        ///< N, frames from one showing to the next
  std::vector<float> cosine{}, sine{};          ///< of the window's frames in C and S
  std::vector<float> cos_delta{}, sin_delta{};  ///< of the patterns shown twice
  std::vector<float> from_middle{};             ///< frames from the window's middle to theirs
};

/// Grey levels of the frames, frame by frame: frame n begins at n * motion_block_pixels.
using MotionLevels = std::vector<float>;

/// Results of each pixel of a block.
struct MotionBlock {
  using Row = std::array<float, motion_block_pixels>;

  Row speed{};        ///< v, rad a frame
  Row unexplained{};  ///< standard deviation of the rest, grey levels; 0 for K = 1
  Row modulation{};   ///< grey levels
  Row evidence{};     ///< square of the change that v explains, grey levels^2
};

/// Sets all of `block`.
void measure_motion(const MotionWeights& weights, const MotionLevels& levels, MotionBlock& block);

}  // namespace slipstream
