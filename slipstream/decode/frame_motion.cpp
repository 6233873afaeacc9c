#include "slipstream/decode/frame_motion.h"

#include <cmath>

#include "slipstream/base/numbers.h"
#include "slipstream/base/parallel_rows.h"

namespace slipstream {

MotionMeasurement::MotionMeasurement(const Band& window)
    : N_(static_cast<std::size_t>(window.cycle->steps)),
      K_(window.mean.size() - N_),
      cosine_(window.cosine.begin(), window.cosine.end()),
      sine_(window.sine.begin(), window.sine.end()) {
  const auto& [first, steps, shifts] = *window.cycle;
  for (std::size_t n = 0; n < K_; ++n) {
    const double turn = two_pi * static_cast<double>(n) / steps;
    const double delta = (shifts.backwards ? -turn : turn) - shifts.origin;
    cos_delta_.push_back(static_cast<float>(std::cos(delta)));
    sin_delta_.push_back(static_cast<float>(std::sin(delta)));
    from_middle_.push_back(static_cast<float>(n) - 0.5F * static_cast<float>(K_ - 1));
  }
}

/// `I(n)`: frame n.
template <class Intensity>
MotionMeasurement::PixelMotion MotionMeasurement::motion_at(const Intensity& I) const {
  float C = 0, S = 0;
  for (std::size_t n = 0; n < cosine_.size(); ++n) {
    C += cosine_[n] * I(n);
    S += sine_[n] * I(n);
  }
  const auto N = static_cast<float>(N_);
  float speed = 0, left = 0, explained = 0;
  // The phase at which the slope is taken also moves: a second pass uses the speed of the first.
  for (int pass = 0; pass < 2; ++pass) {
    float along = 0, length = 0, square = 0;
    for (std::size_t n = 0; n < K_; ++n) {
      const float turned = speed * from_middle_[n];
      const float slope = (C - turned * S) * sin_delta_[n] - (S + turned * C) * cos_delta_[n];
      const float change = I(n + N_) - I(n);
      along += change * slope;
      length += slope * slope;
      square += change * change;
    }
    const float ratio = length > 0 ? along / length : 0;  // 2 sin(N v / 2)
    speed = 2 / N * std::asin(std::clamp(ratio / 2, -1.0F, 1.0F));
    explained = ratio * along;
    left = square - explained;
  }
  const float differences = 2 * static_cast<float>(K_ - 1);  // each is of two frames
  return {.speed = speed,
          .unexplained = K_ > 1 ? std::sqrt(std::max(left, 0.0F) / differences) : 0,
          .modulation = std::hypot(C, S),
          .evidence = explained};
}

void MotionMeasurement::operator()(const FrameViews& frames, FrameMotion& motion) const {
  const Size size = frames.size();
  for (Image<float>* const image : {&motion.speed, &motion.unexplained}) {
    if (image->size() != size) *image = Image<float>(size);
  }
  frames.visit([&](const auto& views) {
    for_each_pixel(size, [&](int column, int row) {
      const PixelMotion pixel =
          motion_at([&](std::size_t n) { return static_cast<float>(views[n](column, row)); });
      motion.speed(column, row) = pixel.speed;
      motion.unexplained(column, row) = pixel.unexplained;
    });
  });
}

double MotionMeasurement::moving_share(const FrameViews& frames, double least_modulation,
                                       double noise_variance) const {
  constexpr int step = 8;
  constexpr float least_speed = 0.01F, deviations = 5;
  const auto by_noise = static_cast<float>(deviations * deviations * 2 * noise_variance);
  double lit = 0, moving = 0;
  frames.visit([&](const auto& views) {
    for (int row = step / 2; row < frames.size().height; row += step) {
      for (int column = step / 2; column < frames.size().width; column += step) {
        const PixelMotion pixel =
            motion_at([&](std::size_t n) { return static_cast<float>(views[n](column, row)); });
        if (pixel.modulation < least_modulation) continue;
        ++lit;
        moving += std::abs(pixel.speed) > least_speed && pixel.evidence > by_noise ? 1 : 0;
      }
    }
  });
  return lit > 0 ? moving / lit : 0;
}

}  // namespace slipstream
