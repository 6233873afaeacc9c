#include "frames/scan_camera.h"

#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/frame_source.h"
#include "tests/io/expect_error.h"

namespace slipstream::pattern_sink_test {

using Picture = Image<std::uint8_t>;

TEST(ScanCamera, RequirePatternsTakesPatternsOfOneSizeAndOfTheDevices) {
  EXPECT_NO_THROW(require_patterns({Picture({6, 4}), Picture({6, 4})}, std::nullopt, "a folder"));
  EXPECT_NO_THROW(require_patterns({Picture({6, 4})}, Size{6, 4}, "monitor 1"));
}

TEST(ScanCamera, RequirePatternsSaysWhatDoesNotFit) {
  expect_error([] { require_patterns({}, Size{6, 4}, "monitor 1"); }, {"no pattern"});
  expect_error(
      [] {
        require_patterns({Picture({4, 6})}, Size{6, 4}, "monitor 1");
      },
      {"the patterns are 4x6, but monitor 1 is 6x4"});
  expect_error(
      [] {
        require_patterns({Picture({6, 4}), Picture({4, 6})}, std::nullopt, "a folder");
      },
      {"the patterns are 4x6, but the first is 6x4"});
}

}  // namespace slipstream::pattern_sink_test

namespace slipstream::scan_camera_test {

using namespace std::chrono_literals;

FrameSet set_of(std::uint8_t level, int changed_rows = 0) {
  Image<std::uint8_t> image({40, 30}, level);
  for (int row = 0; row < changed_rows; ++row) {
    for (int column = 0; column < image.width(); ++column) image(column, row) += 40;
  }
  return FrameSet(std::vector{image, image});
}

TEST(ScanCamera, StillnessFollowsWhatChangesByMoreThanNoise) {
  EXPECT_TRUE(is_still(set_of(100), set_of(100)));
  EXPECT_TRUE(is_still(set_of(100), set_of(110)));
  EXPECT_FALSE(is_still(set_of(100), set_of(140)));
  EXPECT_FALSE(is_still(set_of(100), set_of(100, 1)));
  EXPECT_FALSE(is_still(set_of(100), FrameSet(std::vector{Image<std::uint8_t>({40, 30}, 100)})));
  EXPECT_FALSE(is_still(FrameSet(), set_of(100)));
}

TEST(ScanCamera, StillnessKnowsTheCamerasBits) {
  const auto of_12_bits = [](std::uint16_t level) {
    return FrameSet(std::vector{Image<std::uint16_t>({8, 8}, level)}, 12);
  };
  EXPECT_TRUE(is_still(of_12_bits(1000), of_12_bits(1200)));
  EXPECT_FALSE(is_still(of_12_bits(1000), of_12_bits(1300)));
}

/// A projector and a camera in one, whose frame shows the number of the pattern, two frames late
/// where it has its own pace.
class Rig : public PatternSink, public FrameSource {
 public:
  explicit Rig(bool paced) : paced_(paced) {}

  [[nodiscard]] std::optional<Size> size() const override { return std::nullopt; }
  void load(std::vector<Image<std::uint8_t>> patterns) override { patterns_ = std::move(patterns); }
  void show(std::size_t n) override {
    late_ = paced_ ? 2 : 0;
    on_show_ = n;
    ++shown_;
  }
  [[nodiscard]] std::uint64_t shown() const override { return shown_; }
  [[nodiscard]] FrameFormat format() const override { return {{8, 8}, 8}; }
  [[nodiscard]] bool has_own_pace() const override { return paced_; }
  void start() override {}
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override {
    if (paced_ && timeout == 0ms) return Arrival::nothing;
    const std::uint8_t level = late_ > 0 ? 77 : patterns_.at(on_show_)(0, 0) + moved_;
    late_ = std::max(0, late_ - 1);
    frame = Frame(format());
    frame.pixels = Image<std::uint8_t>({8, 8}, level);
    return Arrival::frame;
  }
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override { return {}; }
  [[nodiscard]] std::string state() const override { return {}; }

  std::uint8_t moved_ = 0;

 private:
  bool paced_;
  std::vector<Image<std::uint8_t>> patterns_;
  std::size_t on_show_ = 0;
  std::uint64_t shown_ = 0;
  int late_ = 0;
};

std::vector<std::vector<Image<std::uint8_t>>> patterns() {
  const auto level = [](std::uint8_t value) { return Image<std::uint8_t>({4, 4}, value); };
  return {{level(10), level(20), level(30)}, {level(40), level(50)}};
}

int level_of(const FrameSet& frames, std::size_t n) {
  return frames.visit([&](const auto& views) { return static_cast<int>(views[n](3, 3)); });
}

TEST(ScanCamera, ShownScansTakesAFrameOfEachPatternAndShowsLightMeanwhile) {
  for (const bool paced : {false, true}) {
    Rig rig(paced);
    ShownScans camera(rig, rig, patterns(), {.settling = 1ms});
    const auto first = camera.look(100ms), second = camera.look(100ms);
    ASSERT_TRUE(first && second);
    EXPECT_FALSE(first->still);
    EXPECT_TRUE(second->still);
    EXPECT_EQ(level_of(second->frames.front(), 0), 50) << "as bright as the brightest";
    const auto scans = camera.take();
    ASSERT_TRUE(scans);
    ASSERT_EQ(scans->size(), 2U);
    EXPECT_EQ(level_of((*scans)[0], 0), 10);
    EXPECT_EQ(level_of((*scans)[0], 2), 30);
    EXPECT_EQ(level_of((*scans)[1], 1), 50);
  }
}

TEST(ScanCamera, ShownScansTakesNothingOfWhatMovedMeanwhile) {
  Rig rig(false);
  ShownScans camera(rig, rig, patterns());
  ASSERT_TRUE(camera.look(100ms));
  rig.moved_ = 60;
  EXPECT_FALSE(camera.take());
}

TEST(ScanCamera, ShownScansNeedsPatterns) {
  Rig rig(false);
  EXPECT_THROW(ShownScans(rig, rig, {}), Error);
}

}  // namespace slipstream::scan_camera_test
