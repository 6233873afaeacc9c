#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "check/frame_model.h"
#include "check/judged_scan.h"
#include "check/scan_samples.h"
#include "slipstream/check.h"
#include "slipstream/sequence.h"
#include "slipstream/strategy.h"

namespace slipstream::synthetic_frames_test {

constexpr Size size{320, 240};

/// The level of frame n at a pixel.
using Level = std::function<double(int n, int column, int row)>;

/// 16-bit pictures with these levels.
inline std::vector<Image<std::uint16_t>> pictures_of(int frames, const Level& level) {
  std::vector<Image<std::uint16_t>> pictures;
  for (int n = 0; n < frames; ++n) {
    Image<std::uint16_t>& picture = pictures.emplace_back(size);
    for_each_pixel_in_order(size, [&](int column, int row) {
      picture(column, row) = static_cast<std::uint16_t>(std::lround(level(n, column, row)));
    });
  }
  return pictures;
}

/// A scan whose camera pixels see one projector pixel each, read as that strategy.
struct SyntheticScan {
  SyntheticScan(const Strategy& strategy, const Level& level, int bits = 8, double least_range = 22,
                std::optional<MeasuredResponse> response = {})
      : sequence{.strategy = strategy, .projector = size},
        photometry{.noise_variance = 1.0 / 12, .response = response} {
    samples.take(FrameSet(pictures_of(samples.frames(), level), bits),
                 {.least_range = least_range});
  }

  [[nodiscard]] JudgedScan judged(const Scanner* scanner = nullptr) const {
    return {model, samples, sequence, scanner, photometry, settings};
  }

  Sequence sequence;
  PhotometricCalibration photometry;  ///< with the noise of rounding
  CheckSettings settings{};
  FrameModel model{sequence, photometry};
  ScanSamples samples{size, model.layout().frames};
};

/// The column as a coordinate.
inline double along(double column) {
  return column / size.width;
}

/// Frames of a strategy along x, from `dark` to `dark` + `range`.
inline Level shown(const Strategy& strategy, double dark, double range) {
  return [=](int n, int column, int) { return dark + range * strategy.shape(n, along(column)); };
}

}  // namespace slipstream::synthetic_frames_test
