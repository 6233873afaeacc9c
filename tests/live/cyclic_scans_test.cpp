#include "live/cyclic_scans.h"

#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "tests/live/virtual_loop.h"

namespace slipstream::cyclic_scans_test {

using namespace std::chrono_literals;

const Strategy strategy = DualFrequency{.steps = 4, .high = 4, .low = 1};

/// Four cycles of a scan along x, one along y and, optionally, a marker; starts at frame `first`.
std::vector<Frame> two_scans(bool marker, std::size_t first = 0) {
  const Sequence sequence{.strategy = strategy, .projector = {1280, 800}, .marker = marker};
  std::vector<Frame> frames;
  for (int cycle = 0; cycle < 4; ++cycle) {
    for (const PatternSet& set : along_both_axes(sequence)) {
      const VirtualLoop loop{
          .cycles = 1,
          .photometry = {
              .ambient = 5, .noise_variance = 1.5, .seed = static_cast<std::uint64_t>(cycle + 1)}};
      for (Frame& frame : frames_of(set, loop)) frames.push_back(std::move(frame));
    }
  }
  frames.erase(frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(first));
  for (Frame& frame : frames) frame.stamp.pattern_index.reset();
  return frames;
}

const std::uint8_t* pixels_of(const FrameSet& frames, std::size_t n) {
  const std::uint8_t* pixels = nullptr;
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (sizeof(Pixel) == 1) pixels = views[n].row(0);
  });
  return pixels;
}

/// Expects two scans whose frames match a whole cycle, in order.
void expect_in_order(const std::vector<FrameSet>& scans) {
  const std::vector<Frame> cycle = two_scans(false);
  ASSERT_EQ(scans.size(), 2U);
  for (std::size_t k = 0; k < 16; ++k) {
    const auto& expected = std::get<Image<std::uint8_t>>(cycle[k].pixels);
    const std::uint8_t* const seen = pixels_of(scans[k / 8], k % 8);
    double sum = 0;
    for (std::size_t i = 0; i < expected.pixel_count(); ++i) {
      sum += std::abs(seen[i] - expected.begin()[i]);
    }
    EXPECT_LT(sum / static_cast<double>(expected.pixel_count()), 3) << k;
  }
}

TEST(CyclicScans, GivesWholeCyclesOfWhatStandsStill) {
  VirtualCamera source(two_scans(false));
  source.start();
  CyclicScans camera(source, {.strategy = strategy}, 2);
  const auto first = camera.look(10s), second = camera.look(10s);
  ASSERT_TRUE(first && second);
  EXPECT_FALSE(first->still);
  EXPECT_TRUE(second->still);
  const auto scans = camera.take();
  ASSERT_TRUE(scans);
  expect_in_order(*scans);
}

TEST(CyclicScans, FindsItsPlaceByTheMarker) {
  for (const std::size_t first : {0U, 5U, 16U}) {
    VirtualCamera source(two_scans(true, first));
    source.start();
    CyclicScans camera(source, {.strategy = strategy, .marker = true}, 2);
    const auto glimpse = camera.look(10s);
    ASSERT_TRUE(glimpse) << first;
    expect_in_order(glimpse->frames);
  }
}

TEST(CyclicScans, SeveralTakeNoFramesOfMotion) {
  VirtualCamera camera(two_scans(false));
  const Sequence moving{.strategy = PhaseMeasuring{4, 1}, .motion = 2};
  EXPECT_NO_THROW(CyclicScans(camera, moving, 1));
  EXPECT_THROW(CyclicScans(camera, moving, 2), Error);
}

TEST(CyclicScans, NothingIsTakenBeforeAGlimpse) {
  VirtualCamera source(two_scans(false));
  CyclicScans camera(source, {.strategy = strategy}, 2);
  EXPECT_FALSE(camera.take());
}

TEST(CyclicScans, ExposuresOneWindowOfASourceIsInPatternOrder) {
  const Scanner scanner = example_scanner({64, 48});
  const Sequence sequence{.strategy = DualFrequency{}};
  const auto loop =
      virtual_frames(scanner, scene_named("board", scanner), pattern_set(sequence), {}, 1);
  VirtualCamera camera(loop);
  const FrameSet frames = take_window(camera, sequence, "the camera");
  ASSERT_EQ(frames.count(), frame_count(sequence));
  const FrameSet twice = joined({frames, frames});
  ASSERT_EQ(twice.count(), 2 * frame_count(sequence));
  twice.visit([&](const auto& views) {
    for (std::size_t n = 0; n < views.size(); ++n) {
      const auto& expected = std::get<Image<std::uint8_t>>(loop[n % loop.size()].pixels);
      EXPECT_EQ(views[n](30, 20), expected(30, 20));
    }
  });
}

}  // namespace slipstream::cyclic_scans_test
