// Right scans of Gray codes: stripes that cameras blur, bend, sharpen and compress are no mistakes.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "slipstream/frame_set.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"
#include "tests/check/mistakes.h"
#include "tests/check/scene_scan.h"

namespace slipstream::right_codes_test {

/// The scan as a camera writes it that sharpens: each pixel overshoots against its neighbours.
void sharpen(Scan& scan) {
  Pictures pictures = pictures_of(scan);
  for (Image<std::uint8_t>& picture : pictures) {
    const Image<std::uint8_t> seen = picture;
    for (int row = 1; row + 1 < seen.height(); ++row) {
      for (int column = 1; column + 1 < seen.width(); ++column) {
        const double around = (seen(column - 1, row) + seen(column + 1, row) +
                               seen(column, row - 1) + seen(column, row + 1)) /
                              4.0;
        const double level = seen(column, row) + 0.8 * (seen(column, row) - around);
        picture(column, row) = static_cast<std::uint8_t>(std::clamp(level, 0.0, 255.0));
      }
    }
  }
  scan.frames = FrameSet(std::move(pictures));
}

// A code is right as long as its bits stay on their side of the threshold.
TEST(RightCodes, OfOrdinaryCamerasAreLeftInPeace) {
  const auto tone_curve = [](double gamma) {
    return [gamma](double level, int, int) { return 255 * std::pow(level / 255, 1 / gamma); };
  };
  const auto darker = [](double gain) {
    return [gain](double level, int, int) { return gain * level; };
  };

  for (const char* const reference : {"inverse", "white-black"}) {
    const Strategy strategy = make_strategy("gray", {{"bits", 9}, {"reference", reference}});
    VirtualWorld world{.scanner = example_scanner({640, 480})};
    world.scene = scene_named("statue", world.scanner);
    world.photometry = {.ambient = 3, .noise_variance = 1.5};
    const VirtualScan taken =
        take_scan(world.scanner, world.scene, pattern_set(strategy, Axis::x), world.photometry);
    const Scan right{.frames = taken.frames,
                     .sequence = {strategy, Axis::x, {}, world.scanner.projector.size},
                     .scanner = as_calibrated(world)};
    const int frames = right.frames.count();

    const std::vector<std::pair<std::string, std::function<void(Scan&)>>> cameras{
        {"gamma 2.2", pixels(all_frames(frames), tone_curve(2.2))},
        {"gamma 1.6", pixels(all_frames(frames), tone_curve(1.6))},
        {"sharpened", sharpen},
        {"a frame of 85 %", pixels({frames - 2}, darker(0.85))},
        {"other frames of 90 %", pixels({0, 3, 4, 7}, darker(0.9))}};
    for (const auto& [name, change] : cameras) {
      Scan scan = right;
      change(scan);
      EXPECT_EQ(told(check_scan(scan)), "") << reference << ", " << name;
    }
  }
}

// The projector's and the camera's blur leave little of stripes of one pixel.
TEST(RightCodes, FinestStripesAreLeftInPeace) {
  const VirtualWorld world = virtual_world({.world = "bench"});
  for (const char* const reference : {"white-black", "inverse"}) {
    const Strategy strategy = make_strategy("gray", {{"bits", 10}, {"reference", reference}});
    EXPECT_EQ(told(findings_of(world, strategy)), "") << reference;
  }
}

// Along y, pixels below each other show which stripes are too fine, not those side by side.
TEST(RightCodes, FineStripesAlongYAreLeftInPeaceAndSwappedFramesAreNot) {
  const Strategy strategy = make_strategy("gray", {{"bits", 9}, {"reference", "inverse"}});
  for (const char* const scene : {"statue", "boxes"}) {
    for (const int width : {160, 224, 320, 512}) {
      const VirtualWorld world = virtual_world(
          {.scene = scene, .camera = {width, width * 3 / 4}, .world = "bench,tone-curve"});
      Scan scan{.sequence = {strategy, Axis::y, {}, world.scanner.projector.size}};
      scan.frames =
          take_scan(world.scanner, world.scene, pattern_set(strategy, Axis::y), world.photometry)
              .frames;
      EXPECT_EQ(told(check_scan(scan)), "") << scene << ", " << width;

      scan.frames = reordered(std::move(scan.frames),
                              {2, 1, 0, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17});
      EXPECT_NE(told(check_scan(scan)), "") << scene << ", " << width;
    }
  }
}

// A tone curve moves what is blurred to one side of the middle of white and black.
TEST(RightCodes, BlurredStripesAreNotRefusedThroughAToneCurve) {
  const Strategy strategy = make_strategy("gray", {{"bits", 9}, {"reference", "white-black"}});
  const VirtualWorld blurred = virtual_world(
      {.camera = {320, 240}, .world = "harsh,no-response,no-interreflection,tone-curve"});
  const ScanFindings found = findings_of(blurred, strategy);
  EXPECT_FALSE(any_wrong(found.findings)) << told(found);
}

// Compression leaves no noise where several frames of a code are black.
TEST(RightCodes, CompressedFramesOfACodeAreNotCalledTheSame) {
  for (const char* const scene : {"sphere", "statue"}) {
    VirtualWorld world = virtual_world({.scene = scene, .camera = {320, 240}});
    world.photometry.physics.jpeg_quality = 50;
    for (const char* const reference : {"white-black", "inverse"}) {
      const Sequence sequence{make_strategy("gray", {{"bits", 9}, {"reference", reference}}),
                              Axis::y,
                              {},
                              world.scanner.projector.size};
      const VirtualScan taken =
          take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
      EXPECT_EQ(told(check_frames(taken.frames, sequence, as_calibrated(world))), "")
          << scene << ", " << reference;
    }
  }
}

TEST(RightCodes, DimStripesAreBlamedOnTheLightOnce) {
  const VirtualWorld dim = virtual_world({.reflectivity = 0.06, .ambient = 20});
  const ScanFindings found = findings_of(dim, make_strategy("gray", {{"bits", 10}}));
  EXPECT_EQ(found.findings.size(), 1U) << told(found);
}

}  // namespace slipstream::right_codes_test
