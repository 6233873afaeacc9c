// Noise-free, unquantised virtual scans come out at their true depth.
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <string_view>
#include <tuple>

#include <gtest/gtest.h>

#include "decode/equations.h"
#include "reconstruct/pipeline.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::virtual_scans_test {

struct DepthError {
  double rms = 0;
  std::size_t points = 0;
  std::size_t lit = 0;
};

DepthError compare(const BasicCloud<double>& cloud, const VirtualScan& scan) {
  DepthError error;
  double sum = 0;
  for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
    if (!std::isnan(scan.coordinate.begin()[i])) ++error.lit;
    if (std::isnan(cloud.z.begin()[i])) continue;
    const double difference = cloud.z.begin()[i] - scan.depth.begin()[i];
    sum += difference * difference;
    ++error.points;
  }
  error.rms = std::sqrt(sum / static_cast<double>(error.points));
  return error;
}

enum class Bent { neither, camera, projector, both };

Scanner scanner_with(Bent bent) {
  Scanner scanner = example_scanner({160, 120});
  if (bent == Bent::neither || bent == Bent::projector) scanner.camera.distortion = {};
  if (bent == Bent::neither || bent == Bent::camera) scanner.projector.distortion = {};
  return scanner;
}

using Case = std::tuple<std::string_view, Axis, Bent>;

class VirtualScans : public testing::TestWithParam<Case> {};

TEST_P(VirtualScans, ComeOutAtTheirTrueDepth) {
  const auto [scene, axis, bent] = GetParam();
  const Scanner scanner = scanner_with(bent);
  for (const Strategy& strategy :
       {Strategy(PhaseMeasuring{.steps = 3, .frequency = 1}),
        Strategy(PhaseMeasuring{.steps = 5, .frequency = 1}),
        Strategy(DualFrequency{.steps = 4, .low_steps = 3, .high = 16, .low = 1})}) {
    const VirtualScan scan =
        scan_of_scene(scene, scanner, pattern_set(strategy, axis), {.bits = std::nullopt});
    for (const PhaseMethod method :
         {PhaseMethod::equation, PhaseMethod::closed_form, PhaseMethod::tables}) {
      const ReferenceEngine reconstruct(
          {scanner, {.strategy = strategy, .axis = axis}, {.phase_method = method}}, {});
      const DepthError error = compare(reconstruct(scan.frames).cloud, scan);
      EXPECT_LE(error.rms, 1e-6) << strategy.name() << ", " << name_of(method);
      EXPECT_EQ(error.points, error.lit);
      EXPECT_GT(error.points, 1500U);
    }
  }
}

std::string case_name(const testing::TestParamInfo<Case>& info) {
  static constexpr std::array<const char*, 4> bent_names{"pinhole", "camera_bent", "projector_bent",
                                                         "both_bent"};
  const auto [scene, axis, bent] = info.param;
  return std::string(scene) + "_" + std::string(name_of(axis)) + "_" +
         bent_names[static_cast<std::size_t>(bent)];
}

INSTANTIATE_TEST_SUITE_P(
    All, VirtualScans,
    testing::Combine(testing::Values("board", "sphere", "boxes"), testing::Values(Axis::x, Axis::y),
                     testing::Values(Bent::neither, Bent::camera, Bent::projector, Bent::both)),
    case_name);

/// Both engines, which are held to the same.
class VirtualScansEngineOfKind : public testing::TestWithParam<EngineKind> {
 protected:
  [[nodiscard]] static Cloud cloud_of(const FrameViews& frames, const Scanner& scanner,
                                      const Sequence& sequence, ReconstructSettings settings = {}) {
    settings.engine = GetParam();
    settings.clean = CleanSettings::none();
    Engine engine(scanner, sequence, settings);
    EXPECT_EQ(engine.backend_for(frames) == "fused", GetParam() == EngineKind::fused);
    Cloud cloud;
    engine.cloud(frames, cloud);
    return cloud;
  }
};

INSTANTIATE_TEST_SUITE_P(Kind, VirtualScansEngineOfKind,
                         testing::Values(EngineKind::reference, EngineKind::fused),
                         [](const auto& info) {
                           return info.param == EngineKind::fused ? "fused" : "reference";
                         });

TEST_P(VirtualScansEngineOfKind, TwoDisjointBoxesStandAtTheirOwnDepths) {
  const Scanner scanner = example_scanner({320, 240});
  const Strategy strategy = DualFrequency{.steps = 3, .high = 32, .low = 1};
  const Scene boxes = scene_named("boxes", scanner);
  const VirtualScan scan = take_scan(scanner, boxes, pattern_set(strategy, Axis::x),
                                     {.ambient = 5, .noise_variance = 1.55, .bits = 8});
  const Cloud cloud = cloud_of(scan.frames, scanner, {.strategy = strategy});
  double near_sum = 0, far_sum = 0;
  int near_count = 0, far_count = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    const double error = cloud.z.begin()[i] - scan.depth.begin()[i];
    if (std::isnan(error)) continue;
    const bool near = cloud.x.begin()[i] < 0;
    (near ? near_sum : far_sum) += error;
    ++(near ? near_count : far_count);
    ASSERT_LT(std::abs(error), 5);
  }
  ASSERT_GT(near_count, 1000);
  ASSERT_GT(far_count, 1000);
  EXPECT_NEAR(near_sum / near_count, 0, 0.05);
  EXPECT_NEAR(far_sum / far_count, 0, 0.05);
}

TEST_P(VirtualScansEngineOfKind, LeavesOutWhatIsNotMeasuredAndSaysWhy) {
  const Scanner scanner = example_scanner({160, 120});
  const Strategy strategy = DualFrequency{};
  const Scene statue = scene_named("statue", scanner);
  // Bright enough to saturate in places.
  const VirtualScan scan = take_scan(scanner, statue, pattern_set(strategy, Axis::x),
                                     {.ambient = 70, .noise_variance = 1.55, .bits = 8});
  const auto counts_with = [&](const ReconstructSettings& settings) {
    return count_by_validity(cloud_of(scan.frames, scanner, {.strategy = strategy}, settings));
  };
  const auto of = [](const auto& counts, Validity validity) {
    return counts[static_cast<std::size_t>(validity)];
  };
  const auto counts = counts_with({});
  EXPECT_GT(of(counts, Validity::too_dark), 1000U);
  EXPECT_GT(of(counts, Validity::saturated), 100U);
  EXPECT_EQ(of(counts_with({.drop_saturated = false}), Validity::saturated), 0U);
  EXPECT_GT(of(counts_with({.farthest = 600}), Validity::out_of_range), 1000U);

  // Where none is asked for, the depths of the calibration's boards say it.
  Scanner calibrated = scanner;
  calibrated.calibrated_depths = {250, 300};
  const EngineSetup setup{.scanner = calibrated, .sequence = {.strategy = strategy}};
  EXPECT_EQ(depth_range(setup), (DepthRange{125, 600}));
  const auto out_of_range = [&](const ReconstructSettings& settings) {
    const Cloud cloud = cloud_of(scan.frames, calibrated, {.strategy = strategy}, settings);
    return of(count_by_validity(cloud), Validity::out_of_range);
  };
  EXPECT_GT(out_of_range({}), 1000U);
  EXPECT_EQ(out_of_range({.farthest = 5000}), 0U);
}

TEST_P(VirtualScansEngineOfKind, ShowsNoPointOfAWrongFringeOrder) {
  const Scanner scanner = example_scanner({640, 480});
  const Strategy strategy = DualFrequency{.steps = 4, .high = 32, .low = 1};
  const VirtualScan scan = scan_of_scene("statue", scanner, pattern_set(strategy, Axis::x),
                                         {.ambient = 5, .noise_variance = 1.55, .bits = 8});
  const auto wrong_with = [&](const FringeOrderConsensus& consensus) {
    const Cloud cloud =
        cloud_of(scan.frames, scanner, {.strategy = strategy}, {.fringe_order = consensus});
    int wrong = 0;
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      // A fringe is about 60 mm deep here.
      if (std::abs(cloud.z.begin()[i] - scan.depth.begin()[i]) > 30) ++wrong;
    }
    return wrong;
  };
  const FringeOrderConsensus none{.fewest_neighbours = 0, .fewest_if_doubtful = 0};
  EXPECT_GT(wrong_with(none), 20) << "else this shows nothing";
  EXPECT_EQ(wrong_with({}), 0);
}

TEST_P(VirtualScansEngineOfKind, AStripeFromElsewhereIsOutsideTheField) {
  // The pictures upside down: the coordinates are good, but belong to other rays.
  const Scanner scanner = example_scanner({160, 120});
  const Strategy strategy = DualFrequency{};
  const VirtualScan scan =
      scan_of_scene("board", scanner, pattern_set(strategy, Axis::y), {.bits = 8});
  FrameSet::Images8 turned;
  scan.frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      turned.emplace_back(view.size());
      for (int row = 0; row < view.height(); ++row) {
        for (int column = 0; column < view.width(); ++column) {
          turned.back()(column, row) =
              static_cast<std::uint8_t>(view(view.width() - 1 - column, view.height() - 1 - row));
        }
      }
    }
  });
  const auto counts = count_by_validity(
      cloud_of(FrameSet(turned), scanner, {.strategy = strategy, .axis = Axis::y}));
  EXPECT_GT(counts[static_cast<std::size_t>(Validity::outside_field)] +
                counts[static_cast<std::size_t>(Validity::no_point)],
            counts[static_cast<std::size_t>(Validity::valid)] / 4);
}

TEST(VirtualScansEngine, ACoordinatePastTheFieldIsNoPoint) {
  const Scanner scanner = example_scanner({64, 48});
  const DualFrequency strategy{.steps = 4, .high = 8, .low = 0.5};
  constexpr double y = 1.3;
  FrameSet::Images8 frames;
  for (const double f : {strategy.high, strategy.low}) {
    for (int n = 0; n < 4; ++n) {
      const double level = 120 + 100 * std::cos(2 * std::numbers::pi * (f * y - n / 4.0));
      frames.emplace_back(scanner.camera.size, static_cast<std::uint8_t>(std::lround(level)));
    }
  }
  for (const ReconstructSettings& settings :
       {ReconstructSettings{.engine = EngineKind::reference, .phase_method = PhaseMethod::equation},
        ReconstructSettings{.engine = EngineKind::reference, .phase_method = PhaseMethod::tables},
        ReconstructSettings{.engine = EngineKind::fused}}) {
    Engine reconstruct(scanner, {.strategy = strategy}, settings);
    Cloud cloud;
    Maps maps;
    const FrameSet set(frames);
    reconstruct.cloud_and_maps(set, cloud, maps);
    EXPECT_NEAR(maps.coordinate(30, 20), y, 1e-2);
    EXPECT_EQ(point_count(cloud), 0U) << reconstruct.backend_for(set);
  }
}

TEST_P(VirtualScansEngineOfKind, ALargeThresholdLeavesNothing) {
  const Scanner scanner = example_scanner({64, 48});
  const FrameSet frames(FrameSet::Images8(6, Image<std::uint8_t>({64, 48}, 200)));
  const Cloud cloud = cloud_of(frames, scanner, {.strategy = DualFrequency{}},
                               {.minimum_modulation = 504457810.78437746});
  EXPECT_EQ(point_count(cloud), 0U);
}

TEST(VirtualScansEngine, RefusesWhatCannotGiveDepth) {
  const Scanner scanner = example_scanner({160, 120});
  const Sequence dual{.strategy = DualFrequency{}};
  const Sequence periods{.strategy = PhaseMeasuring{.steps = 3, .frequency = 8}};
  EXPECT_THROW(Engine(scanner, periods), Error);
  EXPECT_THROW(Engine(scanner, dual, {.minimum_modulation = -1}), Error);
  EXPECT_THROW(Engine(scanner, dual, {.nearest = 10, .farthest = 5}), Error);
  const FrameSet small(FrameSet::Images8(6, Image<std::uint8_t>({80, 60})));
  for (const EngineKind kind : {EngineKind::reference, EngineKind::fused}) {
    Engine engine(scanner, dual, {.engine = kind});
    Cloud cloud;
    EXPECT_THROW(engine.cloud(small, cloud), Error);
  }
}

}  // namespace slipstream::virtual_scans_test
