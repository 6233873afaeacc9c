#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <thread>

#include <gtest/gtest.h>

#include "simulate/looped_scene.h"
#include "slipstream/error.h"
#include "slipstream/image.h"
#include "slipstream/named_scenes.h"
#include "slipstream/pattern_set.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/simulate/virtual_rig.h"

namespace slipstream::virtual_camera_test {

using namespace std::chrono_literals;

const PatternSet patterns = pattern_set(PhaseMeasuring{.steps = 4, .frequency = 1}, Axis::x);

std::vector<Frame> frames_of(Size size, int cycles, const Eigen::Vector3d& motion,
                             const Photometry& photometry = {}) {
  const Scanner scanner = example_scanner(size);
  Scene scene = scene_named("sphere", scanner);
  for (Body& body : scene) body.motion.step = motion;
  return virtual_frames(scanner, scene, patterns, photometry, cycles);
}

const Image<std::uint8_t>& pixels(const Frame& frame) {
  return std::get<Image<std::uint8_t>>(frame.pixels);
}

bool same_pixels(const Frame& a, const Frame& b) {
  return std::equal(pixels(a).begin(), pixels(a).end(), pixels(b).begin(), pixels(b).end());
}

TEST(VirtualCamera, VirtualFramesAtRestAreThoseOfAScan) {
  const Scanner scanner = example_scanner({64, 48});
  const Photometry photometry{.ambient = 4};
  const VirtualScan scan = take_scan(scanner, scene_named("sphere", scanner), patterns, photometry);
  const auto frames = frames_of({64, 48}, 2, Eigen::Vector3d::Zero(), photometry);
  ASSERT_EQ(frames.size(), 8U);
  for (int n = 0; n < 8; ++n) {
    const Frame& frame = frames[static_cast<std::size_t>(n)];
    EXPECT_EQ(frame.stamp.sequence, static_cast<std::uint64_t>(n));
    EXPECT_EQ(frame.stamp.pattern_index, n % 4);
    scan.frames.views().part(n % 4, 1).visit([&]<class Pixel>(const Frames<Pixel>& views) {
      EXPECT_TRUE(std::equal(pixels(frame).begin(), pixels(frame).end(), views[0].row(0)));
    });
  }
}

TEST(VirtualCamera, VirtualFramesOfAMovingSceneGoToAndFro) {
  const auto frames = frames_of({64, 48}, 6, {1, 0, 0});
  // The column of the light's centre of gravity over four frames: one of each pattern.
  const auto place = [&](std::size_t first) {
    double sum = 0, moment = 0;
    for (std::size_t n = first; n < first + 4; ++n) {
      for (int row = 0; row < 48; ++row) {
        for (int column = 0; column < 64; ++column) {
          const double I = pixels(frames[n])(column, row);
          sum += I;
          moment += I * column;
        }
      }
    }
    return moment / sum;
  };
  EXPECT_GT(place(4), place(0) + 0.1);
  EXPECT_GT(place(8), place(4) + 0.1);
  EXPECT_LT(place(20), place(12) - 0.1);
  EXPECT_LT(std::abs(place(20) - place(0)), 2);
}

TEST(VirtualCamera, VirtualFramesOfATurningSceneGoRound) {
  const Scanner scanner = example_scanner({64, 48});
  Scene scene = scene_named("boxes", scanner);
  for (Body& body : scene) {
    body.motion = {.turn = {0, 2 * std::numbers::pi / 8, 0},
                   .centre = working_volume(scanner).centre};
  }
  const auto frames = virtual_frames(scanner, scene, patterns, {}, 2);
  ASSERT_EQ(frames.size(), 8U);
  for (int n = 0; n < 8; ++n) {
    const VirtualScan seen = take_scan(scanner, scene, pattern_alone(patterns, n % 4), {}, n);
    EXPECT_TRUE(same_pixels(frames[static_cast<std::size_t>(n)], first_frame(seen.frames))) << n;
  }
}

TEST(VirtualCamera, VirtualFramesHaveNoiseOfTheirOwn) {
  const auto frames = frames_of({32, 24}, 2, Eigen::Vector3d::Zero(), {.noise_variance = 4});
  EXPECT_FALSE(same_pixels(frames[0], frames[4]));
}

TEST(VirtualCamera, GivesItsFramesOverAndOver) {
  const auto frames = frames_of({32, 24}, 2, {0, 0, 1});
  VirtualCamera camera(frames);
  EXPECT_FALSE(camera.has_own_pace());
  camera.start();
  Frame frame(camera.format());
  const std::uint8_t* memory = pixels(frame).begin();
  for (std::uint64_t n = 0; n < 20; ++n) {
    ASSERT_EQ(camera.next(frame, 0ms), Arrival::frame);
    EXPECT_EQ(frame.stamp.sequence, n);
    EXPECT_EQ(frame.stamp.pattern_index, static_cast<int>(n % 4));
    EXPECT_TRUE(same_pixels(frame, frames[n % 8]));
  }
  EXPECT_EQ(pixels(frame).begin(), memory);
  EXPECT_EQ(camera.counters().delivered, 20U);
  EXPECT_EQ(camera.counters().lost, 0U);
}

TEST(VirtualCamera, WithARateGivesEachFrameWhenItIsDue) {
  const auto frames = frames_of({32, 24}, 1, Eigen::Vector3d::Zero());
  VirtualCamera camera(frames, 200), slow(frames, 0.01);
  EXPECT_TRUE(camera.has_own_pace());
  Frame frame(camera.format());
  slow.start();
  EXPECT_EQ(slow.next(frame, 1ms), Arrival::nothing);
  const auto start = std::chrono::steady_clock::now();
  camera.start();
  for (int n = 0; n < 4; ++n) {
    while (camera.next(frame, 100ms) != Arrival::frame) {
    }
    EXPECT_GE(std::chrono::steady_clock::now(), frame.stamp.host_time);
    EXPECT_GE(std::chrono::steady_clock::now() - start, (n + 1) * 5ms - 1ms);
  }
}

TEST(VirtualCamera, LosesTheOldestFramesThatNobodyFetches) {
  VirtualCamera camera(frames_of({32, 24}, 1, Eigen::Vector3d::Zero()), 1000);
  camera.start();
  Frame frame(camera.format());
  std::this_thread::sleep_for(60ms);
  ASSERT_EQ(camera.next(frame, 100ms), Arrival::frame);
  EXPECT_GE(frame.stamp.sequence, 50U);
  EXPECT_EQ(camera.counters().lost, frame.stamp.sequence);
  EXPECT_EQ(frame.stamp.pattern_index, static_cast<int>(frame.stamp.sequence % 4));
}

TEST(VirtualCamera, RefusesWhatIsNoCamera) {
  const auto frames = frames_of({32, 24}, 1, Eigen::Vector3d::Zero());
  EXPECT_THROW(VirtualCamera(std::vector<Frame>{}), Error);
  EXPECT_THROW(VirtualCamera(frames, 0), Error);
  EXPECT_THROW(VirtualCamera(frames, std::nan("")), Error);
  EXPECT_THROW(VirtualCamera({Frame({{4, 4}, 8}), Frame({{4, 4}, 12})}), Error);
  EXPECT_THROW(frames_of({32, 24}, 0, Eigen::Vector3d::Zero()), Error);
  EXPECT_THROW(frames_of({32, 24}, 1, Eigen::Vector3d::Zero(), {.bits = std::nullopt}), Error);
}

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

TEST(VirtualCamera, VirtualRigAnswersPatternsWithTheFramesOfTheVirtualScanner) {
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

TEST(VirtualCamera, VirtualRigIsDarkBeforeTheFirstPattern) {
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

TEST(VirtualCamera, VirtualRigHasNoiseOfItsOwnInEachFrameAndMoreBits) {
  VirtualRig rig(scanner, scene_named("board", scanner), {.noise_variance = 4, .bits = 12});
  rig.load({Picture(projector, 128)});
  rig.show(0);
  const Frame first = next_frame(rig), second = next_frame(rig);
  ASSERT_EQ(first.bits, 12);
  const auto& a = std::get<Image<std::uint16_t>>(first.pixels);
  const auto& b = std::get<Image<std::uint16_t>>(second.pixels);
  EXPECT_FALSE(std::equal(a.begin(), a.end(), b.begin()));
}

TEST(VirtualCamera, VirtualRigBodiesGoOnFromFrameToFrame) {
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

TEST(VirtualCamera, VirtualRigRefusesWhatItCannotShowOrSee) {
  const Scene scene = scene_named("board", scanner);
  VirtualRig rig(scanner, scene);
  EXPECT_THROW(rig.load({}), Error);
  EXPECT_THROW(rig.load({Picture({64, 48})}), Error);
  EXPECT_THROW(rig.show(0), std::out_of_range);
  EXPECT_THROW(VirtualRig(scanner, scene, {.bits = std::nullopt}), Error);
  EXPECT_THROW(VirtualRig(scanner, scene, {.rays = 0}), Error);
  EXPECT_THROW(VirtualRig(scanner, scene, {.noise_variance = -1}), Error);
}

}  // namespace slipstream::virtual_camera_test
