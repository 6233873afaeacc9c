#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <gtest/gtest.h>

#include "decode/cue_evidence.h"
#include "decode/decoder.h"
#include "paper/multiplexing_tables.h"
#include "slipstream/phase_channel_multiplexing.h"
#include "slipstream/strategy.h"

namespace slipstream::rounded_frames_test {

FrameSet rounded(const FrameSet& frames) {
  FrameSet::Images8 whole;
  frames.visit([&](const auto& views) {
    for (const auto& frame : views) {
      Image<std::uint8_t>& image = whole.emplace_back(frame.size());
      for (int row = 0; row < frame.height(); ++row) {
        std::transform(frame.row(row), frame.row(row) + frame.width(), image.row(row),
                       [](double grey) { return static_cast<std::uint8_t>(std::lround(grey)); });
      }
    }
  });
  return FrameSet(std::move(whole));
}

TEST(RoundedFrames, Table32IsOfFramesInWholeGreyLevels) {
  const Image<double> y = smooth_coordinate({640, 480});
  for (const UnwrappingCell& cell : unwrapping_table(4, {.size = {64, 48}})) {
    const Strategy strategy =
        PhaseChannelMultiplexing{.steps = 4, .high = cell.high, .share = cell.c1, .reference = {}};
    const CueSettings cue{.light = {.alpha_p = 200, .beta_p = 55},
                          .ambient = -7,
                          .noise_variance = 1.55,
                          .rule = CueRule::published};
    const FrameSet frames =
        rounded(noisy_frames(pattern_set(strategy, Axis::y, cue.light), y, {}, 7));
    const BasicMaps<double> maps =
        Decoder(strategy.layout(), 1140, PhaseMethod::equation, {}, cue)(frames);
    double right = 0;
    for (std::size_t i = 0; i < y.pixel_count(); ++i) {
      const double error = std::abs(maps.coordinate.begin()[i] - y.begin()[i]);
      right += error < 0.5 / cell.high ? 100.0 / static_cast<double>(y.pixel_count()) : 0;
    }
    EXPECT_NEAR(right, cell.published, 0.12) << "f_h " << cell.high << ", c_1 " << cell.c1;
  }
}

}  // namespace slipstream::rounded_frames_test
