// Patterns on a monitor, real or Xvfb; skipped without either.
#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "devices/monitor.h"
#include "slipstream/error.h"
#include "slipstream/pattern_set.h"
#include "slipstream/strategy.h"
#include "tests/view/desktop.h"
#include "view/opengl.h"

namespace slipstream::monitor {
namespace {

std::vector<Image<std::uint8_t>> patterns_of(const Strategy& strategy, Axis axis, Size size) {
  const PatternSet set = pattern_set(strategy, axis);
  std::vector<Image<std::uint8_t>> patterns;
  for (int n = 0; n < set.count; ++n) {
    patterns.push_back(in_8_bits(render_pattern(set, n, size)));
  }
  return patterns;
}

class MonitorSinkOnAMonitor : public testing::Test {
 protected:
  [[nodiscard]] Size size() const { return system_.monitors().at(0).size; }
  /// Shows the patterns in a loop on the first monitor.
  [[nodiscard]] ProjectionReport project(const std::vector<Image<std::uint8_t>>& patterns,
                                         const ProjectionSettings& settings) const {
    MonitorSink sink(system_, 0);
    sink.load(patterns);
    return project_patterns(sink, patterns.size(), settings);
  }

  Desktop desktop_;
  const opengl::WindowSystem system_;
};

TEST_F(MonitorSinkOnAMonitor, EveryPixelHasItsGreyLevel) {
  for (const Axis axis : {Axis::x, Axis::y}) {
    const auto patterns =
        patterns_of(DualFrequency{.steps = 3, .high = 32, .low = 1}, axis, size());
    MonitorSink sink(system_, 0);
    ASSERT_EQ(sink.size(), size());
    sink.load(patterns);
    for (std::size_t n = 0; n < patterns.size(); ++n) {
      sink.draw(n);
      const Image<Colour> shown = opengl::read_pixels(size());
      sink.show(n);
      const bool same = std::equal(shown.begin(), shown.end(), patterns[n].begin(),
                                   [](const Colour& colour, std::uint8_t level) {
                                     return colour == Colour{level, level, level};
                                   });
      EXPECT_TRUE(same) << "pattern " << n;
    }
    EXPECT_EQ(sink.shown(), patterns.size());
  }
}

TEST_F(MonitorSinkOnAMonitor, EveryPixelHasItsColour) {
  MonitorSink sink(system_, 0);
  const std::vector<Strategy> strategies{DeBruijn{}, DualFrequency{.steps = 3, .high = 32}};
  for (const Strategy& strategy : strategies) {
    const auto channels = patterns_of(strategy, Axis::x, size());
    std::vector<Image<Colour>> pictures;
    for (std::size_t n = 0; n < channels.size(); n += 3) {
      pictures.push_back(
          picture_in_colour(pattern_set(strategy, Axis::x), static_cast<int>(n), size()));
    }
    sink.load_in_colour(pictures);
    for (std::size_t n = 0; n < pictures.size(); ++n) {
      sink.draw(n);
      const Image<Colour> shown = opengl::read_pixels(size());
      sink.show(n);
      for (std::size_t i = 0; i < shown.pixel_count(); ++i) {
        const Colour wanted{channels[3 * n].begin()[i], channels[3 * n + 1].begin()[i],
                            channels[3 * n + 2].begin()[i]};
        ASSERT_EQ(shown.begin()[i], wanted) << i;
      }
    }
  }
  EXPECT_THROW(sink.load_in_colour({Image<Colour>({64, 48})}), Error);
  const auto grey = patterns_of(PhaseMeasuring{}, Axis::x, size());
  sink.load(grey);  // grey again after colours
  sink.draw(0);
  const Colour shown = opengl::read_pixels(size())(7, 5);
  EXPECT_EQ(shown, (Colour{grey[0](7, 5), grey[0](7, 5), grey[0](7, 5)}));
}

TEST_F(MonitorSinkOnAMonitor, PatternsComeInTheirOrderAndAreTold) {
  const auto patterns = patterns_of(PhaseMeasuring{.steps = 4, .frequency = 8}, Axis::x, size());
  std::vector<PatternSwap> swaps;
  ProjectionSettings settings;
  settings.on_swap = [&](const PatternSwap& swap) { swaps.push_back(swap); };
  settings.ends = [&] { return swaps.size() >= 10; };
  const ProjectionReport report = project(patterns, settings);
  ASSERT_EQ(swaps.size(), 10U);
  EXPECT_EQ(report.shown, 10U);
  for (std::size_t i = 0; i < swaps.size(); ++i) {
    EXPECT_EQ(swaps[i].sequence, i);
    EXPECT_EQ(swaps[i].pattern, static_cast<int>(i % 4));
    if (i > 0) EXPECT_GT(swaps[i].time, swaps[i - 1].time);
  }
}

TEST_F(MonitorSinkOnAMonitor, APatternStaysForItsRefreshes) {
  const auto patterns = patterns_of(PhaseMeasuring{.steps = 3, .frequency = 8}, Axis::x, size());
  int swaps = 0;
  ProjectionSettings settings;
  settings.hold = 3;
  settings.on_swap = [&](const PatternSwap&) { ++swaps; };
  settings.ends = [&] { return swaps >= 7; };
  const ProjectionReport report = project(patterns, settings);
  EXPECT_EQ(report.shown, 7U);
  EXPECT_EQ(report.refreshes, 6U * 3 + 1);
}

TEST_F(MonitorSinkOnAMonitor, ItEndsWhileAPatternStays) {
  const auto patterns = patterns_of(PhaseMeasuring{.steps = 3, .frequency = 8}, Axis::x, size());
  int asked = 0;
  ProjectionSettings settings;
  settings.hold = 100000;
  settings.ends = [&] { return ++asked > 5; };
  const ProjectionReport report = project(patterns, settings);
  EXPECT_EQ(report.shown, 1U);
  EXPECT_LE(report.refreshes, 6U);
}

TEST_F(MonitorSinkOnAMonitor, PatternsOfAnotherSizeAreRefused) {
  const auto patterns = patterns_of(PhaseMeasuring{}, Axis::x, {64, 48});
  MonitorSink sink(system_, 0);
  EXPECT_THROW(sink.load(patterns), Error);
  EXPECT_THROW(sink.load({}), Error);
}

TEST_F(MonitorSinkOnAMonitor, PatternsTakeThePlaceOfThoseBefore) {
  MonitorSink sink(system_, 0);
  for (const std::uint8_t level : {30, 200}) {
    sink.load({Image<std::uint8_t>(size(), level)});
    sink.draw(0);
    EXPECT_EQ(opengl::read_pixels(size())(5, 5), (Colour{level, level, level}));
  }
  EXPECT_THROW(sink.show(1), std::out_of_range);
}

TEST_F(MonitorSinkOnAMonitor, SaysWhatTheMonitorLacks) {
  const MonitorSink sink(system_, 0);
  EXPECT_EQ(sink.state().empty(), sink.has_gamma_table());
  EXPECT_GT(sink.refresh_hz(), 0);
  EXPECT_FALSE(sink.closed());
}

TEST_F(MonitorSinkOnAMonitor, AMonitorThatIsNotThereIsRefused) {
  EXPECT_THROW(MonitorSink(system_, 99), Error);
  EXPECT_THROW(MonitorSink(system_, -1), Error);
}

/// Records the patterns that it should show.
class WitnessSink : public PatternSink {
 public:
  [[nodiscard]] std::optional<Size> size() const override { return std::nullopt; }
  void load(std::vector<Image<std::uint8_t>>) override {}
  void show(std::size_t n) override { seen.push_back(n); }
  [[nodiscard]] std::uint64_t shown() const override { return seen.size(); }
  [[nodiscard]] std::string state() const override { return {}; }

  std::vector<std::size_t> seen;
};

TEST(MonitorSink, ProjectionShowsPatternsOnAnySink) {
  WitnessSink sink;
  const ProjectionReport report = project_patterns(
      sink, 2, {.refresh_hz = 1000, .hold = 2, .ends = [&] { return sink.shown() >= 7; }});
  EXPECT_EQ(sink.seen, (std::vector<std::size_t>{0, 0, 1, 1, 0, 0, 1}));
  EXPECT_EQ(report.shown, 4U);
  EXPECT_EQ(report.refreshes, 7U);
}

TEST(MonitorSink, ProjectionRefusesWhatShowsNothing) {
  WitnessSink sink;
  EXPECT_THROW(project_patterns(sink, 0, {}), Error);
  EXPECT_THROW(project_patterns(sink, 2, {.hold = 0}), Error);
  EXPECT_THROW(project_patterns(sink, 2, {.refresh_hz = 0}), Error);
}

TEST(MonitorSink, RefreshesForRateAreWholeNumbers) {
  EXPECT_EQ(refreshes_for(60, {}, 60), 1);
  EXPECT_EQ(refreshes_for(30, {}, 59.94), 2);
  EXPECT_EQ(refreshes_for(0.5, {}, 60), 120);
  EXPECT_THROW(refreshes_for(50, {}, 60), Error);
  EXPECT_THROW(refreshes_for(120, {}, 60), Error);
  EXPECT_THROW(refreshes_for(0, {}, 60), Error);
  EXPECT_THROW(refreshes_for(-1, {}, 60), Error);
}

}  // namespace
}  // namespace slipstream::monitor
