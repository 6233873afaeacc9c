#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

#include "decode/frame_adapter.h"
#include "slipstream/error.h"

namespace slipstream::demodulator_test {

using std::numbers::pi;

Demodulation fringes(double periods, int shown = 1) {
  return {.shown = shown, .frames = sine_cosine_mean(periods)};
}

/// A carrier of `period` pixels that leans by `lean`, on a surface that bends its phase.
struct Scene {
  double period = 12, lean = 0.05, bend = 0.5;
  bool along_rows = true;

  [[nodiscard]] double phase(int column, int row) const {
    const double along = along_rows ? column : row, across = along_rows ? row : column;
    return 2 * pi * (along + lean * across) / period +
           bend * std::sin(0.02 * along + 0.01 * across);
  }
  [[nodiscard]] Image<double> frame(Size size, int shift = 0) const {
    Image<double> frame(size);
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        const double shade = 1 + 0.2 * std::sin(0.008 * column) * std::cos(0.01 * row);
        frame(column, row) = shade * (110 + 80 * std::cos(phase(column, row) + pi * shift));
      }
    }
    return frame;
  }
};

/// The greatest error of the phase, rad, but for so many pixels at the edges.
double largest_error(const FrameViews& read, const Scene& scene, int margin) {
  double worst = 0;
  read.visit([&](const auto& frames) {
    for (int row = margin; row < read.size().height - margin; ++row) {
      for (int column = margin; column < read.size().width - margin; ++column) {
        const double mean = static_cast<double>(frames[2](column, row));
        const std::complex<double> z(static_cast<double>(frames[1](column, row)) - mean,
                                     static_cast<double>(frames[0](column, row)) - mean);
        worst = std::max(worst, std::abs(std::arg(z * std::polar(1.0, -scene.phase(column, row)))));
      }
    }
  });
  return worst;
}

class DemodulatorCarriers : public testing::TestWithParam<Scene> {};

TEST_P(DemodulatorCarriers, AreFoundAndTakenOut) {
  const Scene scene = GetParam();
  const Size size{320, 240};
  const double periods = (scene.along_rows ? size.width : size.height) / scene.period;
  // The projector's field is wider or narrower than what the camera sees.
  for (const double scale : {0.5, 1.0, 2.0}) {
    for (const int shown : {1, 2}) {
      FrameSet::ImagesUnquantised frames{scene.frame(size)};
      if (shown == 2) frames.push_back(scene.frame(size, 1));
      Demodulator demodulate(fringes(scale * periods, shown), scene.along_rows ? Axis::x : Axis::y);
      const FrameSet given(std::move(frames));
      EXPECT_LT(largest_error(demodulate(given), scene, 30), 0.02)
          << scene.period << " pixels, scale " << scale << ", frames " << shown;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, DemodulatorCarriers,
                         testing::Values(Scene{}, Scene{.period = 6, .lean = -0.2},
                                         Scene{.period = 17.3, .lean = 0.1},
                                         Scene{.period = 9, .bend = 2},
                                         Scene{.period = 11, .along_rows = false}));

TEST(Demodulator, LeavesOutWhatTheCarrierDoesNotExplain) {
  const Scene scene;
  Image<double> frame = scene.frame({320, 240});
  // Paint of half the reflectivity from the middle on.
  for (int row = 0; row < 240; ++row) {
    for (int column = 160; column < 320; ++column) frame(column, row) *= 0.4;
  }
  Demodulator demodulate(fringes(320 / scene.period), Axis::x);
  demodulate(FrameSet(FrameSet::ImagesUnquantised{frame})).visit([](const auto& frames) {
    const auto is_left_out = [&](int column) {
      return frames[0](column, 120) == frames[2](column, 120) &&
             frames[1](column, 120) == frames[2](column, 120);
    };
    EXPECT_TRUE(is_left_out(160));
    EXPECT_FALSE(is_left_out(100));
    EXPECT_FALSE(is_left_out(220));
  });
}

TEST(Demodulator, KeepsWhatIsSaturated) {
  Image<std::uint8_t> frame({160, 120}, 100);
  frame(80, 60) = 255;
  Demodulator demodulate(fringes(16), Axis::x);
  const FrameSet given(FrameSet::Images8{frame});
  const Image<std::uint8_t> saturated = saturation_mask(demodulate(given));
  EXPECT_EQ(saturated(80, 60), 1);
  EXPECT_EQ(saturated(81, 60), 0);
}

TEST(Demodulator, AnswersWhateverThePictures) {
  for (const Size size : {Size{1, 1}, {3, 2}, {40, 1}, {1, 40}, {64, 64}}) {
    for (const int level : {0, 128, 255}) {
      const FrameSet given(
          FrameSet::Images8{Image<std::uint8_t>(size, static_cast<std::uint8_t>(level))});
      for (const Axis axis : {Axis::x, Axis::y}) {
        EXPECT_EQ(demodulated(fringes(16), axis, given).count(), 3);
      }
    }
  }
}

TEST(Demodulator, RefusesAnotherNumberOfFrames) {
  const FrameSet given(FrameSet::Images8(3, Image<std::uint8_t>({64, 48})));
  EXPECT_THROW(demodulated(fringes(16), Axis::x, given), Error);
}

}  // namespace slipstream::demodulator_test
