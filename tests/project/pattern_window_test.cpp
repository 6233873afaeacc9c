// Patterns on a monitor, that of Xvfb where there is no other; skipped without either.
#include "slipstream/project/pattern_window.h"

#include <algorithm>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error/error.h"
#include "slipstream/opengl/off_screen.h"
#include "slipstream/pattern/pattern_in_8_bits.h"
#include "slipstream/pattern/pattern_set.h"
#include "slipstream/project/projection.h"
#include "slipstream/strategy/strategy.h"
#include "tests/opengl/desktop.h"

namespace slipstream::project {
namespace {

std::vector<Image<std::uint8_t>> patterns_of(const Strategy& strategy, Axis axis, Size size) {
  const PatternSet set = pattern_set(strategy, axis);
  std::vector<Image<std::uint8_t>> patterns;
  for (int n = 0; n < set.count; ++n) {
    patterns.push_back(in_8_bits(render_pattern(set, n, size)));
  }
  return patterns;
}

class OnAMonitor : public testing::Test {
 protected:
  void SetUp() override {
    try {
      system_ = std::make_unique<opengl::WindowSystem>();
    } catch (const WorldError& error) {
      GTEST_SKIP() << error.what();
    }
    if (system_->monitors().empty()) GTEST_SKIP() << "no monitor";
  }
  [[nodiscard]] Size size() const { return system_->monitors().front().size; }

  Desktop desktop_;
  std::unique_ptr<opengl::WindowSystem> system_;
};

TEST_F(OnAMonitor, EveryPixelHasItsGreyLevel) {
  for (const Axis axis : {Axis::x, Axis::y}) {
    const auto patterns =
        patterns_of(DualFrequency{.steps = 3, .high = 32, .low = 1}, axis, size());
    const PatternWindow window(*system_, 0, patterns);
    ASSERT_EQ(window.window().framebuffer_size(), size());
    for (std::size_t n = 0; n < patterns.size(); ++n) {
      window.draw(n);
      const Image<Colour> shown = opengl::read_pixels(size());
      window.show();
      const bool same = std::equal(shown.begin(), shown.end(), patterns[n].begin(),
                                   [](const Colour& colour, std::uint8_t level) {
                                     return colour == Colour{level, level, level};
                                   });
      EXPECT_TRUE(same) << "pattern " << n;
    }
  }
}

TEST_F(OnAMonitor, PatternsComeInTheirOrderAndAreTold) {
  const auto patterns = patterns_of(PhaseMeasuring{.steps = 4, .frequency = 8}, Axis::x, size());
  std::vector<PatternSwap> swaps;
  ProjectionSettings settings;
  settings.on_swap = [&](const PatternSwap& swap) { swaps.push_back(swap); };
  settings.ends = [&] { return swaps.size() >= 10; };
  const ProjectionReport report = project_patterns(*system_, patterns, settings);
  ASSERT_EQ(swaps.size(), 10U);
  EXPECT_EQ(report.shown, 10U);
  for (std::size_t i = 0; i < swaps.size(); ++i) {
    EXPECT_EQ(swaps[i].sequence, i);
    EXPECT_EQ(swaps[i].pattern, static_cast<int>(i % 4));
    if (i > 0) EXPECT_GT(swaps[i].time, swaps[i - 1].time);
  }
}

TEST_F(OnAMonitor, APatternStaysForItsRefreshes) {
  const auto patterns = patterns_of(PhaseMeasuring{.steps = 3, .frequency = 8}, Axis::x, size());
  int swaps = 0;
  ProjectionSettings settings;
  settings.hold = 3;
  settings.on_swap = [&](const PatternSwap&) { ++swaps; };
  settings.ends = [&] { return swaps >= 7; };
  const ProjectionReport report = project_patterns(*system_, patterns, settings);
  EXPECT_EQ(report.shown, 7U);
  EXPECT_EQ(report.refreshes, 6U * 3 + 1);
}

TEST_F(OnAMonitor, ItEndsWhileAPatternStays) {
  const auto patterns = patterns_of(PhaseMeasuring{.steps = 3, .frequency = 8}, Axis::x, size());
  int asked = 0;
  ProjectionSettings settings;
  settings.hold = 100000;
  settings.ends = [&] { return ++asked > 5; };
  const ProjectionReport report = project_patterns(*system_, patterns, settings);
  EXPECT_EQ(report.shown, 1U);
  EXPECT_LE(report.refreshes, 6U);
}

TEST_F(OnAMonitor, PatternsOfAnotherSizeAreRefused) {
  const auto patterns = patterns_of(PhaseMeasuring{}, Axis::x, {64, 48});
  EXPECT_THROW(PatternWindow(*system_, 0, patterns), Error);
}

TEST_F(OnAMonitor, AMonitorThatIsNotThereIsRefused) {
  const auto patterns = patterns_of(PhaseMeasuring{}, Axis::x, size());
  EXPECT_THROW(PatternWindow(*system_, 99, patterns), Error);
  EXPECT_THROW(project_patterns(*system_, patterns, {.monitor = 99}), Error);
  EXPECT_THROW(project_patterns(*system_, patterns, {.hold = 0}), Error);
  EXPECT_THROW(project_patterns(*system_, {}, {}), Error);
}

TEST(RefreshesForRate, AreWholeNumbers) {
  EXPECT_EQ(refreshes_for_rate(60, 60), 1);
  EXPECT_EQ(refreshes_for_rate(30, 59.94), 2);
  EXPECT_EQ(refreshes_for_rate(0.5, 60), 120);
  EXPECT_THROW(refreshes_for_rate(50, 60), Error);
  EXPECT_THROW(refreshes_for_rate(120, 60), Error);
  EXPECT_THROW(refreshes_for_rate(0, 60), Error);
  EXPECT_THROW(refreshes_for_rate(-1, 60), Error);
}

}  // namespace
}  // namespace slipstream::project
