// The published system in one pass. Tier: every change; about a second. every_strategy.h compares
// all engines with truth; here the tables are compared with the stages and the published loops, to
// rounding, and by reason of rejection.
#include "reconstruct/table_engine.h"

#include <gtest/gtest.h>

#include "paper/published_loops.h"
#include "reconstruct/pipeline.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream {
namespace {

struct Case {
  int steps;
  Axis axis;
  bool has_lens;
};

std::ostream& operator<<(std::ostream& to, const Case& of) {
  return to << of.steps << (of.axis == Axis::x ? "_x" : "_y") << (of.has_lens ? "_lens" : "");
}

Scanner scanner_of(const Case& of) {
  Scanner scanner = example_scanner({160, 120});
  scanner.projector.distortion = {};
  if (of.has_lens) scanner.projector.distortion.coefficients = {-0.04, 0.01};
  if (of.axis == Axis::y) scanner.translation = {20, -140, 20};
  return scanner;
}

EngineSetup setup_of(const Case& of) {
  EngineSetup setup{.scanner = scanner_of(of),
                    .sequence = {.strategy = PhaseMeasuring{.steps = of.steps, .frequency = 1},
                                 .axis = of.axis,
                                 .projector = scanner_of(of).projector.size}};
  set_backend(setup.settings, "lut");
  setup.settings.nearest = 300;
  setup.settings.farthest = 700;
  setup.settings.clean = CleanSettings::none();
  return setup;
}

VirtualScan scan_of(const EngineSetup& setup) {
  return scan_of_scene("statue", setup.scanner, pattern_set(setup.sequence),
                       {.ambient = 5, .noise_variance = 1.55});
}

class TableEngineFixed : public testing::TestWithParam<Case> {};

TEST_P(TableEngineFixed, GivesThePointsAndReasonsOfTheStages) {
  const EngineSetup setup = setup_of(GetParam());
  const VirtualScan scan = scan_of(setup);
  std::string why_not;
  const auto tables = TableEngine::make(setup, {}, &why_not);
  ASSERT_TRUE(tables) << why_not;

  Cloud cloud, expected;
  Maps maps, expected_maps;
  ASSERT_TRUE(TableEngine::takes(scan.frames.views()));
  (*tables)(scan.frames.views(), {.cloud = &cloud, .maps = &maps});
  ReferenceEngine(setup, {}).run(scan.frames.views(), {.cloud = &expected, .maps = &expected_maps});

  ASSERT_GT(point_count(expected), 1000U);
  double most = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    ASSERT_EQ(cloud.validity.begin()[i], expected.validity.begin()[i]) << "pixel " << i;
    ASSERT_EQ(cloud.intensity.begin()[i], expected.intensity.begin()[i]) << "pixel " << i;
    ASSERT_EQ(maps.modulation.begin()[i], expected_maps.modulation.begin()[i]) << "pixel " << i;
    ASSERT_NEAR(maps.coordinate.begin()[i], expected_maps.coordinate.begin()[i], 2e-7);
    if (expected.validity.begin()[i] != Validity::valid) continue;
    most = std::max({most, std::abs(double{cloud.x.begin()[i]} - expected.x.begin()[i]),
                     std::abs(double{cloud.y.begin()[i]} - expected.y.begin()[i]),
                     std::abs(double{cloud.z.begin()[i]} - expected.z.begin()[i])});
  }
  EXPECT_LT(most, 2e-3) << "mm";
}

TEST_P(TableEngineFixed, GivesThePointsOfThePublishedLoops) {
  if (GetParam().has_lens) return;  // print ignores the projector's lens
  const EngineSetup setup = setup_of(GetParam());
  const VirtualScan scan = scan_of(setup);
  std::string why_not;
  Cloud cloud;
  (*TableEngine::make(setup, {}, &why_not))(scan.frames.views(), {.cloud = &cloud});

  scan.frames.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
    if constexpr (std::is_same_v<Pixel, std::uint8_t>) {
      PublishedLoops loops(setup.scanner, setup.sequence.axis, frames);
      loops.lut();
      constexpr double rounding = 1e-3;  // mm, of floats
      std::size_t compared = 0;
      for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
        if (cloud.validity(column, row) != Validity::valid) return;
        if (std::isnan(loops.z(column, row))) return;  // darker than its threshold
        ++compared;
        ASSERT_NEAR(cloud.x(column, row), loops.x(column, row), rounding);
        ASSERT_NEAR(cloud.y(column, row), loops.y(column, row), rounding);
        ASSERT_NEAR(cloud.z(column, row), loops.z(column, row), rounding);
      });
      EXPECT_GT(compared, 1000U);
    }
  });
}

INSTANTIATE_TEST_SUITE_P(Steps, TableEngineFixed,
                         testing::Values(Case{3, Axis::x, false}, Case{4, Axis::x, false},
                                         Case{6, Axis::x, false}, Case{3, Axis::x, true},
                                         Case{4, Axis::y, false}, Case{6, Axis::y, true}),
                         testing::PrintToStringParamName());

TEST(TableEngine, RefusesOtherPatternsWithTheReason) {
  EngineSetup setup = setup_of({4, Axis::x, false});
  const auto refused = [&](const Strategy& strategy) {
    setup.sequence.strategy = strategy;
    std::string why_not;
    return TableEngine::make(setup, {}, &why_not) ? std::string("taken") : why_not;
  };
  const std::string other = "patterns other than 3, 4 or 6 steps of one period";
  EXPECT_EQ(refused(PhaseMeasuring{.steps = 5, .frequency = 1}), other);
  EXPECT_EQ(refused(DualFrequency{.steps = 3, .high = 16, .low = 1}), other);
  EXPECT_EQ(refused(PhaseMeasuring{.steps = 6, .frequency = 1}), "taken");
  EXPECT_EQ(refused(Strategy(PhaseMeasuring{.steps = 4, .frequency = 1}).in_motion(2, 0)),
            "extra frames for motion");
}

TEST(TableEngine, TakesTheExampleScannerWithAndWithoutADepthRange) {
  for (const Size size : {Size{160, 120}, Size{640, 480}}) {
    for (const bool has_range : {true, false}) {
      EngineSetup setup = setup_of({4, Axis::x, true});
      setup.scanner = example_scanner(size);
      if (!has_range) setup.settings.nearest = setup.settings.farthest = {};
      std::string why_not;
      EXPECT_TRUE(TableEngine::make(setup, {}, &why_not)) << why_not;
    }
  }
}

TEST(TableEngine, IsTheEngineOfBackendLut) {
  const EngineSetup setup = setup_of({4, Axis::x, false});
  const VirtualScan scan = scan_of(setup);
  Engine engine(setup);
  EXPECT_EQ(engine.backend_for(scan.frames.views()), "lut");
  Cloud cloud;
  engine.cloud(scan.frames.views(), cloud);
  EXPECT_GT(point_count(cloud), 1000U);
  EXPECT_EQ(engine.fallback_reason(), "");

  const FrameSet words(FrameSet::Images16(4, Image<std::uint16_t>(setup.scanner.camera.size)));
  EXPECT_EQ(engine.backend_for(words), "equation");
  engine.cloud(words, cloud);
  EXPECT_NE(engine.fallback_reason().find("it requires 8 bits"), std::string::npos);
}

}  // namespace
}  // namespace slipstream
