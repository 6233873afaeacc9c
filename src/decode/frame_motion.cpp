#include "decode/frame_motion.h"

#include <algorithm>
#include <cmath>

#include "base/numbers.h"
#include "base/parallel_rows.h"

namespace slipstream {
namespace {

/// Sets the levels of up to a block of pixels of a row, `step` columns apart from `column` on.
template <class Pixel>
void take_levels(const Frames<Pixel>& frames, int column, int row, int step, std::size_t count,
                 MotionLevels& levels) {
  levels.resize(frames.size() * motion_block_pixels);

  for (std::size_t n = 0; n < frames.size(); ++n) {
    const Pixel* const from = frames[n].row(row) + column;
    float* const to = &levels[n * motion_block_pixels];
    for (std::size_t i = 0; i < count; ++i) {
      to[i] = static_cast<float>(from[i * static_cast<std::size_t>(step)]);
    }
  }
}

/// Measures every `step`-th pixel of the row, from `first` on, and calls `use(column, pixels,
/// count)` for each block of them.
template <class Pixel, class Use>
void measure_row(const MotionWeights& weights, const Frames<Pixel>& frames, int first, int row,
                 int step, const Use& use) {
  thread_local MotionLevels levels;
  MotionBlock block;

  const int width = frames.front().width(), reach = step * static_cast<int>(motion_block_pixels);
  for (int column = first; column < width; column += reach) {
    // The pixels left in the row, at most a block.
    const int left = (width - column + step - 1) / step;
    const std::size_t count = std::min(static_cast<std::size_t>(left), motion_block_pixels);

    take_levels(frames, column, row, step, count, levels);
    measure_motion(weights, levels, block);
    use(column, block, count);
  }
}

}  // namespace

MotionMeasurement::MotionMeasurement(const Band& window)
    : weights_{.cycle = static_cast<std::size_t>(window.cycle->steps),
               .cosine = {window.cosine.begin(), window.cosine.end()},
               .sine = {window.sine.begin(), window.sine.end()}} {
  const auto& [first, steps, shifts] = *window.cycle;
  const std::size_t K = window.mean.size() - weights_.cycle;

  // The shift of each pattern shown twice, and its distance from the window's middle, frames.
  for (std::size_t n = 0; n < K; ++n) {
    const double turn = two_pi * static_cast<double>(n) / steps;
    const double delta = (shifts.backwards ? -turn : turn) - shifts.origin;
    weights_.cos_delta.push_back(static_cast<float>(std::cos(delta)));
    weights_.sin_delta.push_back(static_cast<float>(std::sin(delta)));
    weights_.from_middle.push_back(static_cast<float>(n) - 0.5F * static_cast<float>(K - 1));
  }
}

void MotionMeasurement::operator()(const FrameViews& frames, FrameMotion& motion) const {
  const Size size = frames.size();
  for (Image<float>* const image : {&motion.speed, &motion.unexplained}) {
    if (image->size() != size) *image = Image<float>(size);
  }

  frames.visit([&](const auto& views) {
    for_each_row(size.height, [&](int row) {
      measure_row(
          weights_, views, 0, row, 1, [&](int column, const MotionBlock& block, std::size_t count) {
            std::copy_n(block.speed.begin(), count, motion.speed.row(row) + column);
            std::copy_n(block.unexplained.begin(), count, motion.unexplained.row(row) + column);
          });
    });
  });
}

double MotionMeasurement::moving_share(const FrameViews& frames, double least_modulation,
                                       double noise_variance) const {
  constexpr int step = 8;
  constexpr float least_speed = 0.01F, deviations = 5;

  // The square of a change between two frames has twice the noise variance.
  const auto by_noise = static_cast<float>(deviations * deviations * 2 * noise_variance);

  double lit = 0, moving = 0;
  frames.visit([&](const auto& views) {
    for (int row = step / 2; row < frames.size().height; row += step) {
      measure_row(weights_, views, step / 2, row, step,
                  [&](int, const MotionBlock& block, std::size_t count) {
                    for (std::size_t i = 0; i < count; ++i) {
                      if (block.modulation[i] < least_modulation) continue;

                      ++lit;
                      const bool fast = std::abs(block.speed[i]) > least_speed;
                      moving += fast && block.evidence[i] > by_noise ? 1 : 0;
                    }
                  });
    }
  });

  return lit > 0 ? moving / lit : 0;
}

}  // namespace slipstream
