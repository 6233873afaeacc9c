#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "io/image_file.h"
#include "slipstream/check.h"
#include "slipstream/error.h"
#include "slipstream/frame_set.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scanner_file.h"
#include "slipstream/virtual_world.h"
#include "tests/check/mistakes.h"
#include "tests/check/scene_scan.h"
#include "tests/every_strategy.h"
#include "tests/shared_data.h"

namespace slipstream::right_scans_test {

namespace fs = std::filesystem;

// From one pixel of a large picture to the next a single period changes by less than its noise.
TEST(RightScans, LargePicturesAreLeftInPeace) {
  VirtualWorld world{.scanner = example_scanner({1280, 960})};
  world.scene = scene_named("board", world.scanner);
  world.scene.front().texture = uniform_texture(0.25);
  world.photometry = {.ambient = 3, .noise_variance = 3};
  for (const char* const name : {"pmp", "pcmp", "dual-frequency"}) {
    EXPECT_EQ(told(findings_of(world, make_strategy(name, {{"steps", 5}}))), "") << name;
  }
  EXPECT_EQ(told(findings_of(world, make_strategy("dual-frequency",
                                                  {{"steps", 8}, {"low_steps", 3}, {"high", 6}}))),
            "");
}

class RightScansEveryStrategy : public testing::TestWithParam<std::tuple<const char*, Strategy>> {};

TEST_P(RightScansEveryStrategy, IsLeftInPeace) {
  const auto& [scene, strategy] = GetParam();
  VirtualWorld world{.scanner = example_scanner({640, 480})};
  world.photometry = {.ambient = 3, .noise_variance = 1.5};
  const Sequence sequence{strategy, Axis::x, {}, world.scanner.projector.size};

  const VirtualScan taken =
      scan_of_scene(scene, world.scanner, pattern_set(sequence), world.photometry);
  EXPECT_EQ(told(check_frames(taken.frames, sequence, as_calibrated(world))), "")
      << label_of(strategy) << ", " << scene;
}

INSTANTIATE_TEST_SUITE_P(Scenes, RightScansEveryStrategy,
                         testing::Combine(testing::Values("boxes", "statue"),
                                          testing::ValuesIn(every_strategy())));

// The first bit of a code, and a part of each sinusoid, is dark wherever the object is.
TEST(RightScans, ObjectsInHalfOfTheLightAreLeftInPeace) {
  VirtualWorld world{.scanner = example_scanner({640, 480})};
  world.scene = scene_named("statue", world.scanner);
  world.photometry = {.ambient = 3, .noise_variance = 1.5};

  for (const Strategy& strategy :
       {make_strategy("gray", {{"bits", 9}, {"reference", "inverse"}}),
        make_strategy("gray", {{"bits", 9}, {"reference", "white-black"}}),
        make_strategy("gray-phase", {}), make_strategy("multi-frequency", {})}) {
    const VirtualScan taken =
        take_scan(world.scanner, world.scene, pattern_set(strategy, Axis::x), world.photometry);
    const Scan whole{.frames = taken.frames,
                     .sequence = {strategy, Axis::x, {}, world.scanner.projector.size},
                     .scanner = as_calibrated(world)};

    for (const bool first : {true, false}) {
      Scan half = whole;
      pixels(all_frames(half.frames.count()), [&](double level, int column, int row) {
        const double y = taken.coordinate(column, row);
        const bool is_lit = first ? y < 0.45 : y > 0.55;
        return is_lit ? level : 3;
      })(half);
      EXPECT_EQ(told(check_scan(half)), "") << label_of(strategy) << ", first: " << first;
    }
  }
}

// Frames of motion are seen through the response as the cycle's own are.
TEST(RightScans, FramesOfMotionAreLeftInPeace) {
  VirtualWorld world{.scanner = example_scanner({320, 240})};
  world.scene = scene_named("statue", world.scanner);
  world.photometry = {.ambient = 3, .response = PowerLaw{2.2}, .noise_variance = 1.5};
  const Sequence moving{.strategy = make_strategy("pmp", {{"steps", 4}}), .motion = 2};
  const VirtualScan taken =
      take_scan(world.scanner, world.scene, pattern_set(moving), world.photometry);
  Scan scan{.frames = taken.frames, .sequence = moving, .scanner = as_calibrated(world)};
  scan.scanner->photometry.response = MeasuredResponse{PowerLaw{2.2}, 2.2, 0.01};
  EXPECT_THROW(check_scan(scan), Error) << "six frames, a cycle of four";
  EXPECT_EQ(told(check_scan(merged(scan))), "");
}

// Seen by a small thing in the middle of the field, the first frame is dark all over.
TEST(RightScans, SmallThingsAreLeftInPeace) {
  VirtualWorld world{.scanner = example_scanner({640, 480})};
  const WorkingVolume volume = working_volume(world.scanner);
  world.scene = scene_named("sphere", world.scanner);
  world.scene.front().shape = Sphere{0.04 * volume.extent};
  world.photometry = {.ambient = 3, .noise_variance = 1};
  for (const int steps : {3, 4, 6}) {
    EXPECT_EQ(told(findings_of(world, make_strategy("pmp", {{"steps", steps}}))), "") << steps;
    EXPECT_EQ(told(findings_of(world, make_strategy("pcmp", {{"steps", steps}}))), "") << steps;
  }
}

/// Frames of several exposures, merged.
Scan merged_scan(const WorldSettings& settings, const Strategy& strategy,
                 const std::vector<double>& exposures, const std::vector<int>& order = {}) {
  const VirtualWorld world = virtual_world(settings);
  const Sequence sequence{
      .strategy = strategy, .projector = world.scanner.projector.size, .exposures = exposures};
  VirtualScan taken =
      scan_of_scene(settings.scene, world.scanner, pattern_set(sequence), world.photometry);
  if (!order.empty()) taken.frames = reordered(std::move(taken.frames), order);
  return merged(
      {.frames = std::move(taken.frames), .sequence = sequence, .scanner = as_calibrated(world)});
}

// Beside pixels that are saturated at every exposure, others are right.
TEST(RightScans, MergedExposuresAreNotRefused) {
  int warned = 0;
  for (const char* const world : {"ideal", "bench"}) {
    for (const Strategy& strategy :
         {make_strategy("dual-frequency", {{"steps", 4}, {"high", 16}}),
          make_strategy("dual-frequency", {{"steps", 3}, {"high", 24}}),
          make_strategy("multi-frequency", {}), make_strategy("gray-phase", {})}) {
      for (const std::vector<double>& exposures :
           {std::vector<double>{1, 4, 16}, {1, 4}, {0.25, 1, 4}}) {
        const WorldSettings settings{
            .scene = "contrast",
            .camera = {320, 240},
            .world = world,
            .seed = static_cast<std::uint64_t>(10 * exposures.size() + strategy.name().size())};
        const ScanFindings found = check_scan(merged_scan(settings, strategy, exposures));
        EXPECT_FALSE(any_wrong(found.findings)) << label_of(strategy) << ": " << told(found);
        EXPECT_TRUE(found.order.empty());
        for (const Finding& finding : without_cause(found.findings, CauseKind::overexposure)) {
          ++warned;
          ADD_FAILURE() << world << ", " << label_of(strategy) << ": " << text_of(finding);
        }
      }
    }
  }
  EXPECT_EQ(warned, 0);
}

TEST(RightScans, MergedExposuresOfSwappedFramesAreRefused) {
  const Strategy strategy = make_strategy("dual-frequency", {{"steps", 4}, {"high", 16}});
  const WorldSettings settings{.scene = "contrast", .camera = {320, 240}};
  std::vector<int> order;
  for (int e = 0; e < 3; ++e) {
    for (const int n : {0, 2, 1, 3, 4, 5, 6, 7}) order.push_back(8 * e + n);
  }
  const ScanFindings found = check_scan(merged_scan(settings, strategy, {1, 4, 16}, order));
  EXPECT_TRUE(any_wrong(found.findings));
  EXPECT_NE(told(found).find("swapped"), std::string::npos) << told(found);
}

// The room's light, relative to the projector's, is no plane over the picture.
TEST(RightScans, LightThatChangesAcrossThePictureIsNotCalledGamma) {
  for (const std::uint64_t seed : {3U, 4U, 5U}) {
    for (const char* const scene : {"statue", "board"}) {
      const WorldSettings settings{.scene = scene,
                                   .camera = {480, 360},
                                   .world = "harsh,no-response,no-interreflection",
                                   .seed = seed};
      const Scan scan = merged_scan(settings, make_strategy("two-plus-one", {}), {0.5, 1, 2});
      EXPECT_EQ(told(check_scan(scan)), "") << scene << ", seed " << seed;
    }
  }
}

// The optical axis of rectified pictures may lie anywhere.
TEST(RightScans, RectifiedPicturesAreNotCalledCropped) {
  VirtualWorld world = virtual_world({.camera = {640, 480}, .world = "ideal"});
  world.scanner.camera.intrinsic(0, 2) -= 0.28 * 640;
  world.scanner.camera.distortion = {};
  const Strategy strategy = make_strategy("dual-frequency", {{"steps", 4}, {"high", 16}});
  EXPECT_EQ(told(findings_of(world, strategy)), "");
  world.photometry.response = PowerLaw{2.2};
  VirtualScan taken =
      take_scan(world.scanner, world.scene, pattern_set(strategy, Axis::x), world.photometry);
  std::vector<int> order{1, 0, 2, 3, 4, 5, 6, 7};
  const ScanFindings found = check_scan({.frames = reordered(std::move(taken.frames), order),
                                         .sequence = {strategy, Axis::x, {}, {1280, 800}},
                                         .scanner = world.scanner});
  EXPECT_EQ(told(found).find("optical axis"), std::string::npos) << told(found);
}

TEST(RightScans, DeclaredMotionIsNotCalledGammaOrMixedFrames) {
  for (const int steps : {3, 4, 5}) {
    WorldSettings settings{.scene = "sphere", .camera = {320, 240}, .world = "ideal"};
    settings.motion.step = {3, 0, 0};
    const VirtualWorld world = virtual_world(settings);
    Sequence sequence{.strategy = make_strategy("pmp", {{"steps", steps}, {"frequency", 1}}),
                      .projector = world.scanner.projector.size,
                      .motion = 2};
    const VirtualScan taken =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
    const Scan scan =
        merged({.frames = taken.frames, .sequence = sequence, .scanner = as_calibrated(world)});
    EXPECT_EQ(told(check_scan(scan)), "") << steps;
  }
}

// A hand that moves through 28.5 periods, taken by rectified cameras of others.
TEST(RightScans, DeclaredMotionOfARealHandIsLeftInPeace) {
  const fs::path folder = shared_data() / "bsc-hand";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  int warned = 0;  // of 20
  for (const char* const camera : {"cam1", "cam2"}) {
    for (const int extra : {2, 4}) {
      const Sequence sequence{.strategy = make_strategy("pmp", {{"steps", 4}, {"frequency", 28.5}}),
                              .projector = {1280, 800},
                              .motion = extra};
      for (int first = 0; first + 4 + extra <= 40; first += 8) {
        std::vector<fs::path> frames;
        for (int n = first; n < first + 4 + extra; ++n) {
          frames.push_back(folder / camera / fmt::format("{:04}.png", n));
        }
        const Scan scan = merged({.frames = read_frames(frames).frames, .sequence = sequence});
        if (told(check_scan(scan)).empty()) continue;
        ++warned;
      }
    }
  }
  EXPECT_LE(warned, 1);
}

TEST(RightScans, RealScansWithNoiseAreLeftInPeace) {
  const fs::path folder = shared_data() / "skull";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  std::vector<fs::path> files;
  for (int n = 0; n < 6; ++n) {
    files.push_back(folder / fmt::format("dual-frequency/frameSeq_{:02}.png", n));
  }
  const Scan right{
      .frames = read_frames(files).frames,
      .sequence = {make_strategy("dual-frequency", {{"steps", 3}, {"high", 16}, {"low", 1}}),
                   Axis::x,
                   {},
                   {1824, 1140}}};
  for (unsigned seed = 1; seed <= 4; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 2);  // grey levels
    Scan scan = right;
    pixels(all_frames(6), [&](double level, int, int) { return level + noise(random); })(scan);
    EXPECT_EQ(told(check_scan(scan)), "") << "seed " << seed;
  }
}

/// A world whose projector has that gamma, and what the check says of its scans.
struct BentWorld {
  explicit BentWorld(double gamma, const char* scene = "statue") {
    world.scene = scene_named(scene, world.scanner);
    world.photometry = {.ambient = 3, .response = PowerLaw{gamma}, .noise_variance = 1.5};
  }
  [[nodiscard]] Scan scan_of(const Sequence& sequence) const {
    const VirtualScan taken =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
    Scan scan{.frames = taken.frames, .sequence = sequence, .scanner = as_calibrated(world)};
    scan.sequence.projector = world.scanner.projector.size;
    return scan;
  }
  VirtualWorld world{.scanner = example_scanner({320, 240})};
};

bool warns_of(const ScanFindings& found, CauseKind cause) {
  return std::ranges::any_of(found.findings, [&](const Finding& finding) {
    return finding.severity == Severity::doubtful && blames(finding, cause);
  });
}

// No other evidence shows gamma in so few steps and periods. Linear frames prove that they are.
TEST(RightScans, UnknownResponsesAreToldWhereTheyBendThePhaseUnseen) {
  const std::vector<Strategy> few{
      make_strategy("pmp", {{"steps", 3}}),
      make_strategy("two-plus-one", {}),
      make_strategy("fast-three-step", {}),
      make_strategy("dual-frequency", {{"steps", 3}, {"high", 4}}),
      make_strategy("dual-frequency", {{"steps", 3}, {"high", 8}}),
      make_strategy("multi-frequency", {{"steps", 3}, {"periods", "1,4,16"}}),
      make_strategy("gray-phase", {{"steps", 3}, {"periods", 16}})};
  for (const char* const scene : {"statue", "board", "boxes"}) {
    for (const Strategy& strategy : few) {
      Scan bent = BentWorld(2.2, scene).scan_of({strategy});
      EXPECT_TRUE(warns_of(check_scan(bent), CauseKind::gamma)) << label_of(strategy) << scene;
      EXPECT_TRUE(warns_of(check_frames(bent.frames, bent.sequence, {}), CauseKind::gamma));
      bent.scanner->photometry.response = MeasuredResponse{PowerLaw{2.2}, 2.2, 0.01};
      EXPECT_EQ(told(check_scan(bent)), "") << label_of(strategy) << ", known";
      EXPECT_EQ(told(check_scan(BentWorld(1, scene).scan_of({strategy}))), "")
          << label_of(strategy) << ", linear";
    }
  }
}

// All sinusoids are brighter than the code's frames are.
TEST(RightScans, UnknownResponsesAreToldWhereTheyPartPhaseAndCode) {
  const Strategy strategy = GrayPhase{.periods = 16, .reference = "inverse"};
  for (const double gamma : {0.65, 0.7, 0.8}) {
    const ScanFindings found = check_scan(BentWorld(gamma, "board").scan_of({strategy}));
    EXPECT_TRUE(warns_of(found, CauseKind::gamma)) << gamma << told(found);
  }
}

TEST(RightScans, OneBitPatternsAreToldInFocusAlone) {
  for (const char* const name : {"fast-three-step", "dual-frequency", "gray-phase"}) {
    Sequence sequence{make_strategy(name, {})};
    sequence.binary = true;
    BentWorld sharp(1, "sphere");
    const ScanFindings found = check_scan(sharp.scan_of(sequence));
    EXPECT_TRUE(warns_of(found, CauseKind::noise)) << name << told(found);
    sharp.world.photometry = photometry_named("bench");
    EXPECT_EQ(told(check_scan(sharp.scan_of(sequence))), "") << name;
  }

  // In focus other settings fit as well by chance: none is proposed.
  Sequence five{make_strategy("dual-frequency", {{"steps", 5}, {"high", 16}})};
  five.binary = true;
  const ScanFindings found = check_scan(BentWorld(1, "statue").scan_of(five));
  EXPECT_TRUE(warns_of(found, CauseKind::noise)) << told(found);
  EXPECT_FALSE(any_wrong(found.findings)) << told(found);
}

TEST(RightScans, StripesAlongTheBaselineAreToldWithTheOtherAxis) {
  BentWorld above(1);
  Scanner& scanner = above.world.scanner;
  scanner.rotation = Eigen::AngleAxisd(0.22, Eigen::Vector3d::UnitX()).toRotationMatrix();
  scanner.translation = Eigen::Vector3d(0, 176, 40);
  above.world.scene = scene_named("board", scanner);
  const Strategy strategy = make_strategy("dual-frequency", {{"steps", 4}});
  const ScanFindings found = check_scan(above.scan_of({strategy}));
  EXPECT_TRUE(warns_of(found, CauseKind::axis)) << told(found);
  EXPECT_EQ(told(check_scan(above.scan_of({strategy, Axis::y}))), "");
}

TEST(RightScans, ScannersInOtherUnitsAreToldByTheirSize) {
  Scan scan = BentWorld(1).scan_of({make_strategy("dual-frequency", {{"steps", 4}})});
  scan.scanner->calibrated_depths.reset();
  EXPECT_GT(check_scan(scan).median_depth, 300);
  for (const double units_of_mm : {10.0, 25.4}) {
    Scan other = scan;
    other.scanner->translation /= units_of_mm;
    const ScanFindings found = check_scan(other);
    EXPECT_TRUE(warns_of(found, CauseKind::scanner_file)) << told(found);
  }
}

TEST(RightScans, RealScansAreLeftInPeace) {
  const fs::path folder = shared_data() / "skull";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const Sequence dual{make_strategy("dual-frequency", {{"steps", 3}, {"high", 16}, {"low", 1}}),
                      Axis::x,
                      {},
                      {1824, 1140}};
  const Scanner scanner = read_scanner(folder / "calibration.xml");
  const auto check = [&](const std::string& pictures, int first, Sequence sequence) {
    std::vector<fs::path> frames;
    for (int n = 0; n < frame_count(sequence.strategy); ++n) {
      frames.push_back(folder / fmt::format("{}_{:02}.png", pictures, first + n));
    }
    Scan scan{.frames = read_frames(frames).frames, .sequence = std::move(sequence)};
    scan.scanner = completed(scanner, "calibration.xml", scan.frames.size(), {1824, 1140});
    EXPECT_EQ(told(check_scan(scan)), "") << pictures << " from " << first;
    scan.scanner.reset();
    EXPECT_EQ(told(check_scan(scan)), "") << pictures << " from " << first << ", no scanner";
  };
  check("dual-frequency/frameSeq", 0, dual);
  check("pmp/frameSeq", 0, {make_strategy("pmp", {{"steps", 3}}), Axis::x, {}, {1824, 1140}});
  Sequence along_y = dual;
  along_y.axis = Axis::y;
  for (int board = 1; board <= 6; ++board) {
    check(fmt::format("calibration/board{}/frameSeq", board), 0, dual);
    check(fmt::format("calibration/board{}/frameSeq", board), 6, along_y);
  }
}

}  // namespace slipstream::right_scans_test
