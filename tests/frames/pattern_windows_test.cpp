// The index of each frame: how it is known, and what becomes of it when it is wrong.
#include "frames/pattern_windows.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "decode/frame_adapter.h"
#include "tests/live/virtual_loop.h"
#include "tests/own_strategies.h"

namespace slipstream::pattern_windows_test {

/// A frame of the loop as it comes to the windows.
struct Shown {
  int frame = 0;  ///< of the loop, all around
  std::uint64_t sequence = 0;
  std::optional<int> told = {};  ///< the pattern, as the source says it
};

/// What came of it: of every window the sequence of its frames, in pattern order, and whether each
/// frame really shows its pattern.
struct Outcome {
  std::vector<std::vector<std::uint64_t>> windows;
  int wrong = 0;
  std::uint64_t lost = 0, resynchronisations = 0;
  int refused = 0;

  [[nodiscard]] bool has_window_of(std::uint64_t newest) const {
    return std::any_of(windows.begin(), windows.end(), [&](const auto& window) {
      return *std::max_element(window.begin(), window.end()) == newest;
    });
  }
};

/// With a marker the last of each cycle of the loop is one.
Outcome run(const Strategy& strategy, PatternIndexing indexing, const std::vector<Frame>& loop,
            const std::vector<Shown>& script) {
  const int patterns = frame_count(strategy);
  const int cycle = patterns + (indexing == PatternIndexing::marker ? 1 : 0);
  PatternWindows windows(pattern_cycle({.strategy = strategy}), indexing,
                         loop.front().format().size);
  Pool<Frame> pool(static_cast<std::size_t>(6 * cycle),
                   [&] { return Frame(loop.front().format()); });
  Outcome outcome;
  std::vector<Pooled<Frame>> window;
  // The loop's frame of each sequence, to know what a window's frames really show.
  std::map<std::uint64_t, int> shown;
  for (const Shown& event : script) {
    Pooled<Frame> frame = pool.take();
    EXPECT_TRUE(frame);
    frame.fill() = loop[static_cast<std::size_t>(event.frame) % loop.size()];
    frame.fill().stamp = {.sequence = event.sequence, .pattern_index = event.told};
    shown[event.sequence] = event.frame % cycle;
    if (!windows.put(frame)) ++outcome.refused;
    while (windows.next(window)) {
      auto& sequences = outcome.windows.emplace_back();
      for (int n = 0; n < patterns; ++n) {
        sequences.push_back(window[static_cast<std::size_t>(n)]->stamp.sequence);
        if (shown[sequences.back()] != n) ++outcome.wrong;
      }
    }
  }
  outcome.lost = windows.lost();
  outcome.resynchronisations = windows.resynchronisations();
  return outcome;
}

/// `count` frames in a row, the first of the loop shown as sequence 0; `told`: the source knows.
std::vector<Shown> in_a_row(int count, int cycle, bool told = false) {
  std::vector<Shown> script;
  for (int n = 0; n < count; ++n) {
    script.push_back(
        {n, static_cast<std::uint64_t>(n), told ? std::optional(n % cycle) : std::nullopt});
  }
  return script;
}

const std::vector<Strategy> strategies{PhaseMeasuring{.steps = 3, .frequency = 1},
                                       PhaseMeasuring{.steps = 4, .frequency = 1},
                                       PhaseMeasuring{.steps = 6, .frequency = 1},
                                       PhaseMeasuring{.steps = 8, .frequency = 1},
                                       DualFrequency{.steps = 3},
                                       DualFrequency{.steps = 4, .low_steps = 3, .high = 8},
                                       CosineSineMean{},
                                       ThreeFrequencies{}};

std::string text_of(const Strategy& strategy) {
  std::string text(strategy.name());
  for (const int steps : step_counts(strategy)) text += " " + std::to_string(steps);
  return text;
}

TEST(PatternWindows, GiveOneWindowForEachFrameOnceThereAreEnough) {
  for (const Strategy& strategy : strategies) {
    SCOPED_TRACE(text_of(strategy));
    const int N = frame_count(strategy);
    const auto loop = frames_of(strategy);
    for (const bool told : {false, true}) {
      const Outcome outcome =
          run(strategy, told ? PatternIndexing::source : PatternIndexing::counted, loop,
              in_a_row(5 * N, N, told));
      EXPECT_EQ(outcome.windows.size(), static_cast<std::size_t>(4 * N + 1));
      EXPECT_EQ(outcome.wrong, 0);
      EXPECT_EQ(outcome.lost, 0U);
      EXPECT_EQ(outcome.resynchronisations, 0U);
    }
  }
}

TEST(PatternWindows, ALostFrameCostsTheWindowsThatContainIt) {
  for (const Strategy& strategy : strategies) {
    SCOPED_TRACE(text_of(strategy));
    const int N = frame_count(strategy);
    auto script = in_a_row(6 * N, N);
    const auto gone = static_cast<std::uint64_t>(3 * N + 1);
    script.erase(script.begin() + static_cast<std::ptrdiff_t>(gone));
    const Outcome outcome = run(strategy, PatternIndexing::counted, frames_of(strategy), script);
    EXPECT_EQ(outcome.lost, static_cast<std::uint64_t>(N));
    EXPECT_EQ(outcome.windows.size(), static_cast<std::size_t>(5 * N + 1 - N));
    EXPECT_EQ(outcome.wrong, 0);
    EXPECT_TRUE(outcome.has_window_of(gone - 1));
    EXPECT_TRUE(outcome.has_window_of(gone + static_cast<std::uint64_t>(N)));
    EXPECT_EQ(outcome.resynchronisations, 0U);
  }
}

TEST(PatternWindows, AFrameThatComesLateIsPutInItsPlace) {
  for (const Strategy& strategy : strategies) {
    SCOPED_TRACE(text_of(strategy));
    const int N = frame_count(strategy);
    const auto loop = frames_of(strategy);
    for (int late = 1; late < N; ++late) {
      auto script = in_a_row(6 * N, N);
      const auto place = script.begin() + 2 * N + 1;
      std::rotate(place, place + 1, place + 1 + late);
      const Outcome outcome = run(strategy, PatternIndexing::counted, loop, script);
      EXPECT_EQ(outcome.lost, 0U);
      EXPECT_EQ(outcome.windows.size(), static_cast<std::size_t>(5 * N + 1));
      EXPECT_EQ(outcome.wrong, 0);
      EXPECT_EQ(outcome.refused, 0);
    }
  }
}

TEST(PatternWindows, AFrameThatComesLaterThanAnyWindowCanWaitIsRefused) {
  const Strategy strategy = PhaseMeasuring{.steps = 4, .frequency = 1};
  auto script = in_a_row(24, 4);
  std::rotate(script.begin() + 9, script.begin() + 10, script.begin() + 15);
  const Outcome outcome = run(strategy, PatternIndexing::counted, frames_of(strategy), script);
  EXPECT_EQ(outcome.refused, 1);
  EXPECT_EQ(outcome.lost, 4U);
}

TEST(PatternWindows, ASlipIsFoundAndSetRight) {
  for (const Strategy& strategy : strategies) {
    const int N = frame_count(strategy);
    for (const Eigen::Vector3d& motion :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.5, 0.2, -0.5)}) {
      const auto loop = frames_of(strategy, {.motion = motion, .cycles = 4});
      for (int slip = 1; slip < N; ++slip) {
        for (int at = 2 * N; at < 3 * N; ++at) {
          SCOPED_TRACE(text_of(strategy) + ", by " + std::to_string(slip) + " at " +
                       std::to_string(at));
          auto script = in_a_row(6 * N, N);
          for (auto n = static_cast<std::size_t>(at); n < script.size(); ++n) {
            script[n].frame += slip;
          }
          const Outcome outcome = run(strategy, PatternIndexing::counted, loop, script);
          EXPECT_EQ(outcome.wrong, 0);
          EXPECT_EQ(outcome.resynchronisations, 1U);
          EXPECT_EQ(outcome.lost, static_cast<std::uint64_t>(N - 1));
          EXPECT_EQ(outcome.windows.size(), static_cast<std::size_t>(5 * N + 1 - (N - 1)));
        }
      }
    }
  }
}

TEST(PatternWindows, WhatTheSourceTellsWronglyIsSetRightToo) {
  const Strategy strategy = PhaseMeasuring{.steps = 4, .frequency = 1};
  auto script = in_a_row(40, 4, true);
  for (std::size_t n = 13; n < script.size(); ++n) script[n].told = (*script[n].told + 1) % 4;
  const Outcome outcome = run(strategy, PatternIndexing::source, frames_of(strategy), script);
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_EQ(outcome.resynchronisations, 1U);
  EXPECT_EQ(outcome.lost, 3U);
}

TEST(PatternWindows, ASlipThatTheSourceTellsOfIsNoResynchronisation) {
  const Strategy strategy = PhaseMeasuring{.steps = 4, .frequency = 1};
  auto script = in_a_row(40, 4, true);
  for (std::size_t n = 13; n < script.size(); ++n) {
    script[n].frame += 2;
    script[n].told = script[n].frame % 4;
  }
  const Outcome outcome = run(strategy, PatternIndexing::source, frames_of(strategy), script);
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_EQ(outcome.resynchronisations, 0U);
  EXPECT_EQ(outcome.lost, 3U);
  EXPECT_TRUE(outcome.has_window_of(12));
  EXPECT_TRUE(outcome.has_window_of(16));
}

TEST(PatternWindows, OneFrameOfAnotherPatternIsInNoWindow) {
  for (const Strategy& strategy : strategies) {
    SCOPED_TRACE(text_of(strategy));
    const int N = frame_count(strategy);
    auto script = in_a_row(6 * N, N);
    // The projector shows a picture twice and leaves out the next.
    const auto bad = static_cast<std::size_t>(3 * N + 1);
    script[bad].frame -= 1;
    const Outcome outcome = run(strategy, PatternIndexing::counted, frames_of(strategy), script);
    EXPECT_EQ(outcome.wrong, 0);
    EXPECT_EQ(outcome.resynchronisations, 0U);
    EXPECT_EQ(outcome.lost, static_cast<std::uint64_t>(N));
  }
}

TEST(PatternWindows, MotionIsNoSlip) {
  for (const Strategy& strategy : strategies) {
    const int N = frame_count(strategy);
    for (const Eigen::Vector3d& motion :
         {Eigen::Vector3d(2, 0, 0), Eigen::Vector3d(0, 3, 0), Eigen::Vector3d(0, 0, 2)}) {
      SCOPED_TRACE(text_of(strategy));
      const auto loop = frames_of(strategy, {.motion = motion, .cycles = 4});
      const Outcome outcome = run(strategy, PatternIndexing::counted, loop, in_a_row(16 * N, N));
      EXPECT_EQ(outcome.resynchronisations, 0U);
      EXPECT_EQ(outcome.lost, 0U);
      EXPECT_EQ(outcome.windows.size(), static_cast<std::size_t>(15 * N + 1));
    }
  }
}

TEST(PatternWindows, TwoFrequenciesTellWhereTheyBegin) {
  for (const Strategy& strategy :
       {Strategy(DualFrequency{.steps = 3}), Strategy(DualFrequency{.steps = 4, .low_steps = 3}),
        Strategy(DualFrequency{.steps = 6, .high = 8})}) {
    const int N = frame_count(strategy);
    const auto loop = frames_of(strategy, {.size = {160, 120}});
    for (int begin = 1; begin < N; ++begin) {
      SCOPED_TRACE(text_of(strategy) + " from " + std::to_string(begin));
      auto script = in_a_row(4 * N, N);
      for (Shown& shown : script) shown.frame += begin;
      const Outcome outcome = run(strategy, PatternIndexing::counted, loop, script);
      EXPECT_EQ(outcome.wrong, 0);
      EXPECT_EQ(outcome.resynchronisations, 1U);
      EXPECT_EQ(outcome.windows.size(), static_cast<std::size_t>(3 * N + 1));
    }
  }
}

TEST(PatternWindows, ThreeFrequenciesTellWhereTheyBegin) {
  for (const Strategy& strategy :
       {Strategy(ThreeFrequencies{}), Strategy(ThreeFrequencies{36, 1, 6}),
        Strategy(ThreeFrequencies{6, 36, 1})}) {
    const int N = frame_count(strategy);
    const auto loop = frames_of(strategy, {.size = {160, 120}});
    for (int begin = 0; begin < N; ++begin) {
      SCOPED_TRACE(testing::Message() << highest_frequency(strategy) << " from " << begin);
      auto script = in_a_row(4 * N, N);
      for (Shown& shown : script) shown.frame += begin;
      const Outcome outcome = run(strategy, PatternIndexing::counted, loop, script);
      EXPECT_EQ(outcome.wrong, 0);
      EXPECT_EQ(outcome.resynchronisations, begin == 0 ? 0U : 1U);
      EXPECT_EQ(outcome.windows.size(), static_cast<std::size_t>(3 * N + 1));
    }
  }
}

TEST(PatternWindows, AMarkerTellsWhereTheCycleBegins) {
  for (const Strategy& strategy : strategies) {
    const int N = frame_count(strategy);
    for (const double brightness : {0.0, 1.0}) {
      const auto loop = frames_of(with_marker(pattern_set(strategy, Axis::x), brightness));
      for (int begin = 0; begin <= N; ++begin) {
        SCOPED_TRACE(text_of(strategy) + " from " + std::to_string(begin));
        auto script = in_a_row(4 * (N + 1), N);
        for (Shown& shown : script) shown.frame += begin;
        const Outcome outcome = run(strategy, PatternIndexing::marker, loop, script);
        EXPECT_EQ(outcome.wrong, 0);
        EXPECT_EQ(outcome.resynchronisations, 0U);
        EXPECT_EQ(outcome.lost, 0U);
        EXPECT_GE(outcome.windows.size(), static_cast<std::size_t>(3 * N));
      }
    }
  }
}

TEST(PatternWindows, AMarkerThatSlipsIsFollowed) {
  for (const Strategy& strategy : strategies) {
    const int N = frame_count(strategy);
    const auto loop = frames_of(with_marker(pattern_set(strategy, Axis::x), 0));
    for (int slip = 1; slip <= N; ++slip) {
      SCOPED_TRACE(text_of(strategy) + " by " + std::to_string(slip));
      auto script = in_a_row(6 * (N + 1), N);
      for (std::size_t n = 3 * static_cast<std::size_t>(N); n < script.size(); ++n) {
        script[n].frame += slip;
      }
      const Outcome outcome = run(strategy, PatternIndexing::marker, loop, script);
      EXPECT_EQ(outcome.wrong, 0);
      EXPECT_EQ(outcome.resynchronisations, 1U);
    }
  }
}

TEST(PatternWindows, NothingIsToldFromTheDark) {
  const Strategy strategy = DualFrequency{.steps = 3};
  const auto loop = frames_of(with_marker({.count = 0, .shape = {}}, 0), {.cycles = 30});
  const Outcome outcome = run(strategy, PatternIndexing::counted, loop, in_a_row(60, 6));
  EXPECT_EQ(outcome.windows.size(), 55U);
  EXPECT_EQ(outcome.resynchronisations, 0U);
}

}  // namespace slipstream::pattern_windows_test
