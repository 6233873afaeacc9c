// Checks of live frames as they arrive, with the library's check or another.
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "live/window_engine.h"
#include "slipstream/live_pipeline.h"
#include "tests/live/scripted_source.h"
#include "tests/live/virtual_loop.h"

namespace slipstream::live_check_test {

constexpr Size size{64, 48};
constexpr int steps = 4;
const Strategy strategy = PhaseMeasuring{.steps = steps, .frequency = 1};
const EngineSetup setup{.scanner = example_scanner(size), .sequence = {.strategy = strategy}};

/// Correct frames, except that the third frame is dark in cycles [first, last].
std::unique_ptr<ScriptedSource> disturbed(int cycles, int first, int last) {
  std::vector<Frame> pictures = frames_of(strategy, {.size = size, .cycles = 1});
  pictures.push_back(Frame(pictures.front().format()));
  std::vector<ScriptedStep> script;
  for (int n = 0; n < cycles * steps; ++n) {
    const int cycle = n / steps, pattern = n % steps;
    const bool dark = pattern == 2 && cycle >= first && cycle <= last;
    script.push_back({.frame = dark ? steps : pattern,
                      .sequence = static_cast<std::uint64_t>(n),
                      .pattern_index = pattern});
  }
  return std::make_unique<ScriptedSource>(std::move(pictures), std::move(script));
}

/// Reports dark frames.
std::vector<Finding> look_for_darkness(const FrameViews& window) {
  return window.visit([](const auto& frames) {
    std::vector<Finding> findings;
    for (const auto& frame : frames) {
      double brightest = 0;
      for (int row = 0; row < size.height; ++row) {
        for (int column = 0; column < size.width; ++column) {
          brightest = std::max(brightest, static_cast<double>(frame(column, row)));
        }
      }
      if (brightest < 1) findings.push_back({.what = "a frame is dark"});
    }
    return findings;
  });
}

TEST(LiveCheck, ADisturbanceIsToldWithinTwoCyclesAndSoIsItsEnd) {
  // PatternWindows drops a single odd frame, but accepts several in a row.
  LivePipeline pipeline(disturbed(30, 10, 19), setup, {.check = look_for_darkness});
  run_to_its_end(pipeline);
  const std::vector<LiveFinding> told = pipeline.findings();
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].finding.what, "a frame is dark");
  EXPECT_GE(told[0].begin, 10U * steps);
  EXPECT_LE(told[0].begin, 12U * steps);
  ASSERT_TRUE(told[0].end.has_value());
  EXPECT_GT(*told[0].end, 20U * steps);
  EXPECT_LE(*told[0].end, 22U * steps);
  EXPECT_TRUE(pipeline.statistics().findings.empty());
}

TEST(LiveCheck, TheNewestLookSaysWhatIsAmissNow) {
  LivePipeline pipeline(disturbed(20, 5, 19), setup, {.check = look_for_darkness});
  run_to_its_end(pipeline);
  ASSERT_EQ(pipeline.statistics().findings.size(), 1U);
  EXPECT_EQ(pipeline.statistics().findings[0].what, "a frame is dark");
  EXPECT_FALSE(pipeline.findings().at(0).end.has_value());
}

TEST(LiveCheck, OneWindowOfEachCycleIsLookedAt) {
  int looks = 0;
  LivePipeline pipeline(disturbed(50, 99, 99), setup, {.check = [&looks](const FrameViews& window) {
                          EXPECT_EQ(window.count(), steps);
                          ++looks;
                          return std::vector<Finding>();
                        }});
  run_to_its_end(pipeline);
  EXPECT_EQ(looks, 50);
}

TEST(LiveCheck, WhatItThrowsEndsThePipeline) {
  LivePipeline pipeline(
      disturbed(5, 9, 9), setup,
      {.check = [](const FrameViews&) -> std::vector<Finding> { throw std::runtime_error("no"); }});
  run_to_its_end(pipeline);
  EXPECT_NE(pipeline.failure(), nullptr);
}

/// Changes the frame of pattern 2, in some cycles.
using Disturb = void (*)(Frame& frame);

void expect_told(const Strategy& shown, Disturb disturb, const std::string& cause) {
  constexpr int first = 10, last = 19, cycles = 30;
  const int count = frame_count(shown);
  std::vector<Frame> pictures = frames_of(
      shown, {.size = {160, 120}, .cycles = 1, .photometry = {.ambient = 10, .noise_variance = 1}});
  pictures.push_back(pictures[2]);
  disturb(pictures.back());
  std::vector<ScriptedStep> script;
  for (int n = 0; n < cycles * count; ++n) {
    const int cycle = n / count, pattern = n % count;
    script.push_back({.frame = pattern == 2 && cycle >= first && cycle <= last ? count : pattern,
                      .sequence = static_cast<std::uint64_t>(n),
                      .pattern_index = pattern});
  }
  LivePipeline pipeline(std::make_unique<ScriptedSource>(std::move(pictures), std::move(script)),
                        {.scanner = example_scanner({160, 120}), .sequence = {.strategy = shown}});
  run_to_its_end(pipeline);
  const std::vector<LiveFinding> told = pipeline.findings();
  ASSERT_EQ(told.size(), 1U) << cause;
  EXPECT_TRUE(causes_of(told[0].finding).find(cause) != std::string::npos)
      << text_of(told[0].finding);
  const auto cycle_of = [&](std::uint64_t sequence) { return static_cast<int>(sequence) / count; };
  EXPECT_GE(cycle_of(told[0].begin), first);
  EXPECT_LE(cycle_of(told[0].begin), first + 2) << cause;
  ASSERT_TRUE(told[0].end.has_value()) << cause;
  EXPECT_LE(cycle_of(*told[0].end), last + 3) << cause;
}

template <class Change>
void for_each_level(Frame& frame, const Change& change) {
  auto& picture = std::get<Image<std::uint8_t>>(frame.pixels);
  for (int row = 0; row < picture.height(); ++row) {
    for (int column = 0; column < picture.width(); ++column) {
      std::uint8_t& level = picture(column, row);
      level = static_cast<std::uint8_t>(std::min(255.0, change(level, row) + 0.5));
    }
  }
}

TEST(LiveCheck, ADisturbanceIsNamedWhileItLasts) {
  const std::vector<Strategy> strategies{PhaseMeasuring{.steps = 4}, DualFrequency{.steps = 3},
                                         PhaseChannelMultiplexing{.steps = 6}};
  for (const Strategy& shown : strategies) {
    expect_told(
        shown,
        [](Frame& frame) { for_each_level(frame, [](double level, int) { return 1.06 * level; }); },
        "flickers");
    expect_told(
        shown,
        [](Frame& frame) {
          for_each_level(frame, [](double level, int row) { return row < 60 ? level : 0; });
        },
        "lost");
  }
}

TEST(LiveCheck, FindsNothingInGoodFrames) {
  LivePipeline pipeline(disturbed(20, 99, 99), setup);
  run_to_its_end(pipeline);
  EXPECT_TRUE(pipeline.findings().empty());
}

}  // namespace slipstream::live_check_test
