// What windows of more than a cycle say of motion itself.
#include "decode/frame_motion.h"

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include <gtest/gtest.h>

#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::frame_motion_test {

/// A window of eight periods, whose order nothing tells.
Sequence window_of(int steps, int extra) {
  return {.strategy = PhaseMeasuring{steps, 8, {.origin = 0.4}}, .motion = extra};
}

EngineSetup setup_of(const Scanner& scanner, const Sequence& sequence) {
  return {scanner, sequence, {.clean = CleanSettings::none()}};
}

/// Frames of a phase that moves alike everywhere. A narrow picture is the left part of a wide one.
FrameSet drifting(const Sequence& sequence, double speed, double noise_variance, int width = 512) {
  const PatternSet patterns = pattern_set(sequence);
  std::mt19937_64 random(3);
  std::normal_distribution<double> w(0, std::sqrt(noise_variance));
  FrameSet::ImagesUnquantised images;
  for (int n = 0; n < patterns.count; ++n) {
    Image<double>& image = images.emplace_back(Size{width, 64});
    const double periods = highest_frequency(sequence.strategy);
    const double moved = speed * n / (2 * std::numbers::pi) / periods;
    for (int row = 0; row < 64; ++row) {
      for (int column = 0; column < width; ++column) {
        image(column, row) = 0.5 * patterns.intensity(n, column / 512.0 + moved) + w(random);
      }
    }
  }
  return FrameSet(std::move(images));
}

TEST(FrameMotion, MotionMeasurementIsTheSameAtEveryWidth) {
  const Sequence window = merged_sequence(window_of(4, 2));
  const MotionMeasurement measure(window.strategy.layout().bands.front());
  FrameMotion wide, narrow;
  measure(drifting(window, 0.1, 0), wide);
  for (const int width : {1, 63, 64, 65, 200}) {
    measure(drifting(window, 0.1, 0, width), narrow);
    ASSERT_EQ(narrow.speed.width(), width);
    for_each_pixel_in_order(narrow.speed.size(), [&](int column, int row) {
      ASSERT_EQ(narrow.speed(column, row), wide.speed(column, row)) << width;
      ASSERT_EQ(narrow.unexplained(column, row), wide.unexplained(column, row)) << width;
    });
  }
}

TEST(FrameMotion, MotionMeasurementFindsHowFarThePhaseMovesFromFrameToFrame) {
  for (const int steps : {3, 4, 5, 7}) {
    for (const int extra : {1, 2, 3, 4}) {
      for (const bool backwards : {false, true}) {
        for (const int first : {0, 2}) {
          Sequence sequence = window_of(steps, extra);
          sequence.strategy = PhaseMeasuring{steps, 8, {.origin = 0.4, .backwards = backwards}};
          const Sequence window = merged_sequence(sequence, first);
          const Band& band = window.strategy.layout().bands.front();
          ASSERT_TRUE(MotionMeasurement::is_possible(band));
          for (const double per_cycle : {0.0, 0.04, -0.4, 0.8}) {
            const double speed = per_cycle / steps;
            FrameMotion motion;
            MotionMeasurement measure(band);
            measure(drifting(window, speed, 0), motion);
            for (std::size_t i = 0; i < motion.speed.pixel_count(); ++i) {
              // Of one difference the slope is nothing at two phases.
              if (extra == 1 && i % 7 != 0) continue;
              const double off = std::abs(motion.speed.begin()[i] - speed);
              ASSERT_LT(off, extra == 1
                                 ? 0.4
                                 : (0.02 + 0.6 * std::abs(per_cycle)) * std::abs(speed) + 1e-5)
                  << steps << " + " << extra << " from " << first << ", " << speed;
            }
          }
        }
      }
    }
  }
  EXPECT_FALSE(MotionMeasurement::is_possible(PhaseMeasuring{4, 1}.layout().bands.front()));
  EXPECT_FALSE(MotionMeasurement::is_possible(
      window_of(4, 0).strategy.in_motion(0, 0).layout().bands.front()));
}

TEST(FrameMotion, MotionMeasurementCallsNoiseWhatItIs) {
  for (const int extra : {2, 4}) {
    const Sequence window = merged_sequence(window_of(4, extra));
    FrameMotion motion;
    MotionMeasurement measure(window.strategy.layout().bands.front());
    measure(drifting(window, 0.1, 4), motion);
    double square = 0;
    for (const float sigma : motion.unexplained) square += sigma * sigma;
    EXPECT_NEAR(square / static_cast<double>(motion.unexplained.pixel_count()), 4, 0.2);
  }
}

TEST(FrameMotion, MovedPixelsAreNoneWhereNothingMoves) {
  const Scanner scanner = example_scanner({320, 240});
  const Sequence sequence{.strategy = PhaseMeasuring{4, 1}, .motion = 2};
  const VirtualScan scan = scan_of_scene("statue", scanner, pattern_set(sequence),
                                         {.ambient = 5, .noise_variance = 1.5});
  Cloud cloud;
  Maps maps;
  Engine(setup_of(scanner, sequence)).cloud_and_maps(scan.frames, cloud, maps);
  EXPECT_EQ(count_by_validity(cloud.validity)[static_cast<std::size_t>(Validity::moved)], 0U);
  ASSERT_EQ(maps.motion.size(), cloud.size());
}

/// Of a sphere that moves across the view its outline passes over pixels, which are no points then.
TEST(FrameMotion, MovedPixelsAreThoseThatEdgesPass) {
  const Scanner scanner = example_scanner({320, 240});
  const Sequence sequence = {.strategy = PhaseMeasuring{4, 1}, .motion = 2};
  Scene scene = scene_named("sphere", scanner);
  for (Body& body : scene) {
    body.texture = uniform_texture(0.8);
    body.motion.step = {0.5, 0, 0};  // mm a frame
  }
  const VirtualScan scan =
      take_scan(scanner, scene, pattern_set(sequence), {.noise_variance = 0.5});

  EngineSetup setup = setup_of(scanner, sequence);
  setup.scanner.photometry.noise_variance = 0.5 + 1.0 / 12;
  Engine engine(setup);
  Cloud cloud;
  engine.cloud(scan.frames, cloud);
  Depth depth;
  engine.depth(scan.frames, depth);
  Image<std::uint16_t> numbers;
  engine.depth(scan.frames, DepthScale(), numbers);
  double moved = 0, wrong = 0;
  for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
    const Validity validity = cloud.validity.begin()[i];
    EXPECT_EQ(validity, depth.validity.begin()[i]);
    EXPECT_EQ(validity == Validity::valid, numbers.begin()[i] != 0);
    moved += validity == Validity::moved ? 1 : 0;
    const double error = std::abs(cloud.z.begin()[i] - scan.depth.begin()[i]);
    wrong += validity != Validity::valid || error < 30 ? 0 : 1;
  }
  EXPECT_GT(moved, 300);
  EXPECT_LT(wrong, 20);
}

}  // namespace slipstream::frame_motion_test
