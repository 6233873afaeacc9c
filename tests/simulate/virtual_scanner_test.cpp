#include "slipstream/virtual_scanner.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <variant>

#include <gtest/gtest.h>

#include "simulate/looped_scene.h"
#include "simulate/rendered_reel.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/sequence.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"

namespace slipstream::virtual_scanner_test {

const PatternSet patterns = pattern_set(PhaseMeasuring{.steps = 3, .frequency = 1}, Axis::x,
                                        {.alpha_p = 200, .beta_p = 20});

template <class Pixel>
Image<Pixel> frame(const VirtualScan& scan, int n) {
  Image<Pixel> copy(scan.frames.size());
  scan.frames.views().part(n, 1).visit([&]<class Stored>(const Frames<Stored>& frames) {
    for (int row = 0; row < copy.height(); ++row) {
      for (int column = 0; column < copy.width(); ++column) {
        copy(column, row) = static_cast<Pixel>(frames[0](column, row));
      }
    }
  });
  return copy;
}

TEST(VirtualScanner, IntensityIsEquation32InLightAndShadow) {
  const Scanner scanner = example_scanner({160, 120});
  const VirtualScan scan =
      take_scan(scanner, scene_named("statue", scanner), patterns,
                {.ambient = 7, .response = PowerLaw{2.2}, .bits = std::nullopt});
  const Image<double> seen = frame<double>(scan, 1);
  int lit = 0, dark = 0;
  for (int row = 0; row < 120; ++row) {
    for (int column = 0; column < 160; ++column) {
      const double y = scan.coordinate(column, row), alpha = scan.reflectivity(column, row);
      const double I_p = std::isnan(y) ? 0 : 255 * std::pow(patterns.intensity(1, y) / 255, 2.2);
      ASSERT_NEAR(seen(column, row), alpha * (I_p + 7) + 7, 1e-10);
      ++(std::isnan(y) ? dark : lit);
    }
  }
  EXPECT_GT(lit, 5000);
  EXPECT_GT(dark, 1000);
}

TEST(VirtualScanner, NoiseHasItsVarianceAndSeed) {
  const Scanner scanner = example_scanner({320, 240});
  const Scene board = scene_named("board", scanner);
  const Photometry noisy{.noise_variance = 2, .bits = std::nullopt, .seed = 5};
  const VirtualScan clean = take_scan(scanner, board, patterns, {.bits = std::nullopt});
  const VirtualScan scan = take_scan(scanner, board, patterns, noisy);
  double sum = 0, squares = 0;
  for (int n = 0; n < 3; ++n) {
    const Image<double> a = frame<double>(scan, n), b = frame<double>(clean, n);
    for (std::size_t i = 0; i < a.pixel_count(); ++i) {
      const double w = a.begin()[i] - b.begin()[i];
      sum += w;
      squares += w * w;
    }
  }
  const double count = 3.0 * 320 * 240;
  EXPECT_NEAR(sum / count, 0, 0.01);
  EXPECT_NEAR(squares / count, 2, 0.03);

  const auto same = [&](const VirtualScan& other) {
    const Image<double> a = frame<double>(scan, 0), b = frame<double>(other, 0);
    return std::equal(a.begin(), a.end(), b.begin());
  };
  EXPECT_TRUE(same(take_scan(scanner, board, patterns, noisy)));
  Photometry other_seed = noisy;
  other_seed.seed = 6;
  EXPECT_FALSE(same(take_scan(scanner, board, patterns, other_seed)));
}

TEST(VirtualScanner, RoundsAndClipsToTheBitsOfTheCamera) {
  const Scanner scanner = example_scanner({80, 60});
  Scene board = scene_named("board", scanner);
  for (const int bits : {8, 10, 12, 16}) {
    const double full_scale = (1 << bits) - 1;
    const VirtualScan exact =
        take_scan(scanner, board, patterns, {.ambient = 40, .bits = std::nullopt});
    const VirtualScan scan = take_scan(scanner, board, patterns, {.ambient = 40, .bits = bits});
    EXPECT_EQ(scan.frames.bits(), bits);
    const Image<double> a = frame<double>(scan, 0), b = frame<double>(exact, 0);
    for (std::size_t i = 0; i < a.pixel_count(); ++i) {
      const double expected = std::clamp(b.begin()[i] / 255, 0.0, 1.0) * full_scale;
      ASSERT_NEAR(a.begin()[i], expected, 0.5 + 1e-9);
    }
  }
}

TEST(VirtualScanner, MovingThingsAreSeenWhereTheyAreInEachFrame) {
  const Scanner scanner = example_scanner({160, 120});
  Scene sphere = scene_named("sphere", scanner);
  const VirtualScan still = take_scan(scanner, sphere, patterns);
  sphere.front().motion.step = {5, 0, 0};
  const VirtualScan moving = take_scan(scanner, sphere, patterns);
  const auto equal = [&](int n) {
    const Image<double> a = frame<double>(still, n), b = frame<double>(moving, n);
    return std::equal(a.begin(), a.end(), b.begin());
  };
  EXPECT_TRUE(equal(0));
  EXPECT_FALSE(equal(2));
  // What is told to be there is what was there in the middle, as seen without motion.
  sphere.front().pose.pretranslate(Eigen::Vector3d(5 * 0.5 * (patterns.count - 1), 0, 0));
  sphere.front().motion = {};
  const VirtualScan middle = take_scan(scanner, sphere, patterns);
  for (std::size_t i = 0; i < middle.depth.pixel_count(); ++i) {
    const double depth = middle.depth.begin()[i], told = moving.depth.begin()[i];
    ASSERT_TRUE(std::isnan(depth) == std::isnan(told) && !(std::abs(depth - told) > 1e-9)) << i;
  }
}

TEST(VirtualScanner, StopsBetweenRowsAndLeavesTheRestDark) {
  const Scanner scanner = example_scanner({48, 36});
  const Scene board = scene_named("board", scanner);
  const VirtualScan whole = take_scan(scanner, board, patterns);

  std::atomic<int> asked = 0;
  const auto stop_after = [&](int rows) {
    asked = 0;
    return take_scan(scanner, board, patterns, {}, 0, [&, rows] { return asked++ >= rows; });
  };
  const auto rows_in = [](const VirtualScan& scan) {
    int rows = 0;
    for (int row = 0; row < scan.depth.height(); ++row) {
      const std::span<const double> depths(scan.depth.row(row), scan.depth.width());
      rows += std::ranges::any_of(depths, [](double z) { return std::isfinite(z); }) ? 1 : 0;
    }
    return rows;
  };

  ASSERT_EQ(rows_in(whole), 36);
  const VirtualScan part = stop_after(10);
  EXPECT_EQ(rows_in(part), 10);
  EXPECT_EQ(part.frames.count(), whole.frames.count());
  EXPECT_EQ(std::ranges::max(frame<int>(part, 0)), 0);

  // Asked for each row twice: where its pixels look, and for their light.
  const VirtualScan all = stop_after(1000);
  EXPECT_EQ(asked, 2 * 36);
  EXPECT_TRUE(std::ranges::equal(frame<int>(all, 1), frame<int>(whole, 1)));
}

TEST(VirtualScanner, RefusesLightAndSensorsThatCannotBe) {
  const Scanner scanner = example_scanner({16, 12});
  const Scene board = scene_named("board", scanner);
  EXPECT_THROW(take_scan(scanner, board, patterns, {.response = PowerLaw{0}}), Error);
  EXPECT_THROW(take_scan(scanner, board, patterns, {.noise_variance = -1}), Error);
  EXPECT_THROW(take_scan(scanner, board, patterns, {.bits = 7}), Error);
  Scanner no_baseline = scanner;
  no_baseline.translation.setZero();
  EXPECT_THROW(take_scan(no_baseline, board, patterns), Error);
}

VirtualWorld small_world() {
  return {.scanner = example_scanner({32, 24}), .photometry = {.bits = 8}};
}

Body sheet() {
  return {.shape = Board{80, 60}};
}

std::vector<PatternSet> sets_of() {
  return along_both_axes(
      {.strategy = default_strategy(), .projector = {1280, 800}, .marker = true});
}

TEST(VirtualScanner, MovedBoardStaysForItsCyclesAndMovesWithinOne) {
  const VirtualWorld world = small_world();
  const auto poses = board_poses(world.scanner, 3, 80, 60);
  const ReelScript script = moved_board(world, sheet(), poses, sets_of(), 2);
  const Reel reel = rendered(script);
  std::size_t cycle = 0;
  for (const PatternSet& set : sets_of()) cycle += static_cast<std::size_t>(set.count);
  EXPECT_EQ(cycle, 2U * static_cast<std::size_t>(frame_count(default_strategy())) + 1);
  EXPECT_EQ(reel.order.size(), 3 * 3 * cycle);
  EXPECT_EQ(reel.frames.size(), 3 * 2 * cycle);
  EXPECT_EQ(reel.enough, (2 * 3 + 1) * cycle);
  for (std::size_t k = 0; k < cycle; ++k) {
    EXPECT_EQ(reel.order[k], reel.order[k + cycle]) << "still";
    EXPECT_NE(reel.order[k], reel.order[k + 2 * cycle]) << "moving";
  }
}

TEST(VirtualScanner, MovedBoardNeedsPosesAndCycles) {
  const auto poses = board_poses(small_world().scanner, 1, 80, 60);
  EXPECT_THROW(moved_board(small_world(), sheet(), {}, sets_of(), 2), Error);
  EXPECT_THROW(moved_board(small_world(), sheet(), poses, {}, 2), Error);
  EXPECT_THROW(moved_board(small_world(), sheet(), poses, sets_of(), 0), Error);
}

}  // namespace slipstream::virtual_scanner_test
