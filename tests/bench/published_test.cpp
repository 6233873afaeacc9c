// The rows of Table 2.2 compute what they are named for.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "decode/equations.h"
#include "decode/phase_decoder.h"
#include "paper/published_loops.h"
#include "reconstruct/pipeline.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream::published_test {

class Published : public testing::TestWithParam<int> {};

TEST_P(Published, LoopsGiveThePointsOfTheReferenceEngine) {
  Scanner scanner = example_scanner({80, 60});
  scanner.projector.distortion = {};  // as published
  const Strategy strategy = PhaseMeasuring{.steps = GetParam(), .frequency = 1};
  const VirtualScan scan =
      take_scan(scanner, scene_named("statue", scanner), pattern_set(strategy, Axis::x));
  const ReferenceEngine engine({.scanner = scanner,
                                .sequence = {.strategy = strategy},
                                .settings = {.phase_method = PhaseMethod::equation}},
                               {});
  const BasicCloud<double> cloud = engine(scan.frames).cloud;
  scan.frames.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
    if constexpr (sizeof(Pixel) == 1) {
      PublishedLoops loops(scanner, Axis::x, frames);
      const auto expect_points = [&](const char* name) {
        int points = 0;
        for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
          if (cloud.validity.begin()[i] != Validity::valid) continue;
          ASSERT_NEAR(loops.z.begin()[i], cloud.z.begin()[i], 1e-6) << name;
          ASSERT_NEAR(loops.x.begin()[i], cloud.x.begin()[i], 1e-6) << name;
          ++points;
        }
        EXPECT_GT(points, 500);
      };
      loops.equations();
      expect_points("equations");
      loops.traditional();
      expect_points("traditional");
      loops.lut();
      expect_points("lut");
      for (const auto phase :
           {&PublishedLoops::general, &PublishedLoops::closed_form, &PublishedLoops::mlut_plut}) {
        (loops.*phase)();
        for (const auto point : {&PublishedLoops::inverse, &PublishedLoops::form1,
                                 &PublishedLoops::form2, &PublishedLoops::form3}) {
          (loops.*point)();
          expect_points("point form");
        }
      }
    }
  });
}

/// Calls `test` with loops over a scan of a board.
template <class Test>
void with_loops(const Strategy& strategy, const Test& test) {
  const Scanner scanner = example_scanner({80, 60});
  const VirtualScan scan =
      take_scan(scanner, scene_named("board", scanner), pattern_set(strategy, Axis::x));
  const PhaseMaps maps =
      PhaseDecoder(PhaseMethod::equation, {})(scan.frames, strategy.layout().bands.front());
  scan.frames.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
    if constexpr (sizeof(Pixel) == 1) test(PublishedLoops(scanner, Axis::x, frames), maps);
  });
}

void expect_same(const PublishedLoops& loops, const PhaseMaps& maps) {
  for (std::size_t i = 0; i < maps.modulation.pixel_count(); ++i) {
    ASSERT_NEAR(loops.modulation.begin()[i], maps.modulation.begin()[i], 1e-9);
    if (maps.modulation.begin()[i] < 1) continue;
    ASSERT_NEAR(loops.phase.begin()[i], maps.wrapped_phase.begin()[i], 1e-9);
  }
}

TEST_P(Published, LoopsOfOneResultGiveThatOfTheDecoder) {
  const Strategy strategy = PhaseMeasuring{.steps = GetParam(), .frequency = 1};
  with_loops(strategy, [](PublishedLoops loops, const PhaseMaps& maps) {
    for (const auto& [modulation, phase] :
         {std::pair(&PublishedLoops::general_modulation, &PublishedLoops::general_phase),
          std::pair(&PublishedLoops::closed_modulation, &PublishedLoops::closed_phase),
          std::pair(&PublishedLoops::mlut, &PublishedLoops::plut)}) {
      loops.modulation = loops.phase = Image<double>(maps.modulation.size());
      (loops.*modulation)();
      (loops.*phase)();
      expect_same(loops, maps);
    }
  });
}

TEST(PublishedTwoPlusOne, IsDecodedByTheTablesOfFourSteps) {
  with_loops(TwoPlusOne{.frequency = 1}, [](PublishedLoops loops, const PhaseMaps& maps) {
    loops.two_plus_one();
    expect_same(loops, maps);
  });
}

INSTANTIATE_TEST_SUITE_P(Steps, Published, testing::Values(3, 4, 6));

}  // namespace slipstream::published_test
