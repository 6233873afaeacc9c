#include "slipstream/simulate/virtual_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/base/image.h"
#include "slipstream/codes/pattern_in_8_bits.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream::virtual_rig_test {
using namespace std::chrono_literals;

using Picture = Image<std::uint8_t>;

const Scanner scanner = example_scanner({64, 48});
const Size projector = scanner.projector.size;

PatternSet fringes(Axis axis) {
  return {.count = 3, .axis = axis, .light = {}, .shape = [](int n, double y) {
            return 0.5 + 0.5 * std::cos(2 * std::numbers::pi * (6 * y - n / 3.0));
          }};
}

std::vector<Picture> pictures_of(const PatternSet& patterns) {
  std::vector<Picture> pictures;
  for (int n = 0; n < patterns.count; ++n) {
    pictures.push_back(in_8_bits(render_pattern(patterns, n, projector)));
  }
  return pictures;
}

Frame next_frame(FrameSource& camera) {
  Frame frame(camera.format());
  EXPECT_EQ(camera.next(frame, 0ms), Arrival::frame);
  return frame;
}

const Picture& pixels(const Frame& frame) {
  return std::get<Picture>(frame.pixels);
}

TEST(VirtualRig, AnswersPatternsWithTheFramesOfTheVirtualScanner) {
  const Scene scene = scene_named("sphere", scanner);
  const Photometry photometry{.ambient = 4, .response = PowerLaw{1.8}};
  for (const Axis axis : {Axis::x, Axis::y}) {
    const VirtualScan scan = take_scan(scanner, scene, fringes(axis), photometry);
    VirtualRig rig(scanner, scene, photometry);
    rig.load(pictures_of(fringes(axis)));
    for (const int n : {2, 0, 1}) {
      rig.show(static_cast<std::size_t>(n));
      const Frame frame = next_frame(rig);
      EXPECT_EQ(frame.stamp.pattern_index, n);
      int worst = 0;
      scan.frames.views().part(n, 1).visit([&]<class Pixel>(const Frames<Pixel>& views) {
        for (int row = 0; row < 48; ++row) {
          for (int column = 0; column < 64; ++column) {
            worst = std::max(worst, std::abs(static_cast<int>(views[0](column, row)) -
                                             pixels(frame)(column, row)));
          }
        }
      });
      EXPECT_LE(worst, 2) << "of the picture's rounding";
    }
  }
}

TEST(VirtualRig, IsDarkBeforeTheFirstPattern) {
  VirtualRig rig(scanner, scene_named("board", scanner));
  Frame frame = next_frame(rig);
  EXPECT_EQ(*std::max_element(pixels(frame).begin(), pixels(frame).end()), 0);
  EXPECT_FALSE(frame.stamp.pattern_index);
  rig.load({Picture(projector, 255)});
  rig.show(0);
  frame = next_frame(rig);
  EXPECT_GT(pixels(frame)(32, 24), 100);
  EXPECT_EQ(frame.stamp.sequence, 1U);
  EXPECT_EQ(rig.shown(), 1U);
  EXPECT_EQ(rig.counters().delivered, 2U);
}

TEST(VirtualRig, HasNoiseOfItsOwnInEachFrameAndMoreBits) {
  VirtualRig rig(scanner, scene_named("board", scanner), {.noise_variance = 4, .bits = 12});
  rig.load({Picture(projector, 128)});
  rig.show(0);
  const Frame first = next_frame(rig), second = next_frame(rig);
  ASSERT_EQ(first.bits, 12);
  const auto& a = std::get<Image<std::uint16_t>>(first.pixels);
  const auto& b = std::get<Image<std::uint16_t>>(second.pixels);
  EXPECT_FALSE(std::equal(a.begin(), a.end(), b.begin()));
}

TEST(VirtualRig, BodiesGoOnFromFrameToFrame) {
  Scene scene = scene_named("sphere", scanner);
  for (Body& body : scene) body.motion.step = {0, 0, 5};
  VirtualRig rig(scanner, scene);
  rig.load(pictures_of(fringes(Axis::x)));
  rig.show(0);
  const Frame first = next_frame(rig), second = next_frame(rig);
  EXPECT_FALSE(std::equal(pixels(first).begin(), pixels(first).end(), pixels(second).begin()));
  for (Body& body : scene) {
    body.pose.pretranslate(body.motion.step);
    body.motion = {};
  }
  VirtualRig still(scanner, scene);
  still.load(pictures_of(fringes(Axis::x)));
  still.show(0);
  const Frame there = next_frame(still);
  EXPECT_TRUE(std::equal(pixels(there).begin(), pixels(there).end(), pixels(second).begin()));
}

TEST(VirtualRig, RefusesWhatItCannotShowOrSee) {
  const Scene scene = scene_named("board", scanner);
  VirtualRig rig(scanner, scene);
  EXPECT_THROW(rig.load({}), Error);
  EXPECT_THROW(rig.load({Picture({64, 48})}), Error);
  EXPECT_THROW(rig.show(0), std::out_of_range);
  EXPECT_THROW(VirtualRig(scanner, scene, {.bits = std::nullopt}), Error);
  EXPECT_THROW(VirtualRig(scanner, scene, {.rays = 0}), Error);
  EXPECT_THROW(VirtualRig(scanner, scene, {.noise_variance = -1}), Error);
}

}  // namespace slipstream::virtual_rig_test
