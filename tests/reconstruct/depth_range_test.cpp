// Frames of many periods alone, whose fringe order the range of depth asked for tells.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "reconstruct/depth_unwrapper.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/pipeline.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/grey_image.h"
#include "tests/shared_data.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::depth_range_test {

Strategy fringes(double periods) {
  return PhaseMeasuring{.steps = 3, .frequency = periods};
}

/// Of what is lit, with so many mm before and beyond it.
ReconstructSettings range_around(const VirtualScan& scan, double before, double beyond) {
  ReconstructSettings settings{.clean = CleanSettings::none()};
  double nearest = INFINITY, farthest = 0;
  for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
    if (std::isnan(scan.coordinate.begin()[i])) continue;
    nearest = std::min(nearest, scan.depth.begin()[i]);
    farthest = std::max(farthest, scan.depth.begin()[i]);
  }
  settings.nearest = nearest - before;
  settings.farthest = farthest + beyond;
  return settings;
}

struct Outcome {
  int lit = 0, valid = 0, wrong = 0, doubtful = 0;
  double largest_error = 0;  ///< mm
};

Outcome outcome_of(const Cloud& cloud, const VirtualScan& scan, double wrong_beyond) {
  Outcome outcome;
  for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
    if (std::isnan(scan.coordinate.begin()[i])) continue;
    ++outcome.lit;
    outcome.doubtful += cloud.validity.begin()[i] == Validity::doubtful_order ? 1 : 0;
    if (cloud.validity.begin()[i] != Validity::valid) continue;
    ++outcome.valid;
    const double error = std::abs(cloud.z.begin()[i] - scan.depth.begin()[i]);
    outcome.largest_error = std::max(outcome.largest_error, error);
    outcome.wrong += error > wrong_beyond ? 1 : 0;
  }
  return outcome;
}

class DepthRange : public testing::TestWithParam<Axis> {};

TEST_P(DepthRange, GivesTrueDepthWithoutNoise) {
  const Scanner scanner = example_scanner({160, 120});
  for (const char* scene : {"board", "sphere", "boxes"}) {
    const Strategy strategy = fringes(4);
    const VirtualScan scan =
        scan_of_scene(scene, scanner, pattern_set(strategy, GetParam()), {.bits = std::nullopt});
    const ReconstructSettings settings = range_around(scan, 1, 1);
    const ReferenceResult result = ReferenceEngine(
        {scanner, {.strategy = strategy, .axis = GetParam()}, settings}, {})(scan.frames);
    int lit = 0, points = 0;
    for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
      lit += std::isnan(scan.coordinate.begin()[i]) ? 0 : 1;
      if (result.cloud.validity.begin()[i] != Validity::valid) continue;
      ++points;
      ASSERT_NEAR(result.cloud.z.begin()[i], scan.depth.begin()[i], 1e-6) << scene;
      ASSERT_NEAR(result.maps.coordinate.begin()[i], scan.coordinate.begin()[i], 1e-9) << scene;
    }
    EXPECT_GT(points, 0.99 * lit) << scene;
  }
}

INSTANTIATE_TEST_SUITE_P(Along, DepthRange, testing::Values(Axis::x, Axis::y),
                         [](const auto& info) { return std::string(name_of(info.param)); });

TEST(DepthRangeUnderNoise, ShowsNoWrongOrder) {
  const Scanner scanner = example_scanner({320, 240});
  const VirtualScan scan = scan_of_scene("boxes", scanner, pattern_set(fringes(4), Axis::x),
                                         {.ambient = 5, .noise_variance = 1.6, .bits = 8});
  Engine engine(scanner, {.strategy = fringes(4)}, range_around(scan, 1, 1));
  Cloud cloud;
  engine.cloud(scan.frames, cloud);
  const Outcome outcome = outcome_of(cloud, scan, 20);
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_GT(outcome.valid, 0.95 * outcome.lit);
}

TEST(DepthRangeOfNothing, GivesNoOrder) {
  const Scanner scanner = example_scanner({64, 48});
  const Sequence sequence{.strategy = fringes(4)};
  const ReconstructSettings settings{.nearest = 490, .farthest = 610};
  const Image<float> phase(scanner.camera.size, std::nanf(""));
  const Image<float> modulation(scanner.camera.size, 50.F);

  DepthOrders found;
  DepthUnwrapper({scanner, sequence, settings})(phase, modulation, 255, found);
  EXPECT_EQ(std::ranges::count(found.validity, Validity::valid), 0);
}

TEST(DepthRangeTooWide, IsDoubtfulOrRefusedButNeverWrong) {
  const Scanner scanner = example_scanner({160, 120});
  int refused = 0, doubtful = 0;
  for (const Axis axis : {Axis::x, Axis::y}) {
    const Sequence sequence{.strategy = fringes(12), .axis = axis};
    const VirtualScan scan =
        scan_of_scene("sphere", scanner, pattern_set(sequence), {.noise_variance = 1.6});
    // Ever nearer to the widest range that is taken, from both sides.
    double taken = 1, too_wide = 400;
    for (int i = 0; i < 20; ++i) {
      const double beyond = (taken + too_wide) / 2;
      Cloud cloud;
      try {
        Engine(scanner, sequence, range_around(scan, 1, beyond)).cloud(scan.frames, cloud);
      } catch (const Error& error) {
        EXPECT_NE(std::string_view(error.what()).find("needs less than one"),
                  std::string_view::npos);
        ++refused;
        too_wide = beyond;
        continue;
      }
      const Outcome outcome = outcome_of(cloud, scan, 10);
      EXPECT_EQ(outcome.wrong, 0);
      doubtful += outcome.doubtful;
      taken = beyond;
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(doubtful, 0);
}

TEST(DepthRangeTooWide, IsToldWhatWouldDo) {
  const Scanner scanner = example_scanner({160, 120});
  ReconstructSettings settings{.nearest = 400, .farthest = 900};
  const Sequence sequence{.strategy = fringes(16)};
  std::string message;
  try {
    const Engine engine(scanner, sequence, settings);
  } catch (const Error& error) {
    message = error.what();
  }
  ASSERT_NE(message.find("from 400 to "), std::string::npos);
  const std::size_t at = message.rfind(" to ");
  settings.farthest = std::stod(message.substr(at + 4));
  EXPECT_NO_THROW(Engine(scanner, sequence, settings)) << message;
  settings.farthest.reset();
  EXPECT_THROW(Engine(scanner, sequence, settings), Error);
}

/// Three frames of sixteen periods alone, which cannot tell all of the depths that six frames show:
/// they are 2.8 periods. Black where depth is not within one, as if nothing else stood there.
TEST(DepthRangeOfTheSkull, ShowsThePointsOfBothFrequencies) {
  const std::filesystem::path folder = shared_data() / "skull";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const Scanner scanner = read_scanner(folder / "calibration.xml");
  const std::vector<std::filesystem::path> files = images_in_folder(folder / "dual-frequency");
  ReconstructSettings settings{.clean = CleanSettings::none()};
  Cloud both, alone;
  Engine(scanner, {.strategy = DualFrequency{.steps = 3, .high = 16, .low = 1}}, settings)
      .cloud(read_frames(files).frames, both);
  settings.nearest = 358;
  settings.farthest = 555;
  EXPECT_THROW(Engine(scanner, {.strategy = fringes(16)}, settings), Error);
  settings.nearest = 366;
  settings.farthest = 416;
  FrameSet::Images16 high;
  for (int n = 0; n < 3; ++n) {
    high.push_back(read_grey_image(files[static_cast<std::size_t>(n)]));
    for (std::size_t i = 0; i < high.back().pixel_count(); ++i) {
      const double z = both.z.begin()[i];
      if (!(z > 366 && z < 416)) high.back().begin()[i] = 0;
    }
  }
  Engine(scanner, {.strategy = fringes(16)}, settings).cloud(FrameSet(std::move(high), 8), alone);
  int points = 0, same = 0, wrong = 0;
  for (std::size_t i = 0; i < both.z.pixel_count(); ++i) {
    const double z = both.z.begin()[i];
    if (z > 366 && z < 416) ++points;
    if (alone.validity.begin()[i] != Validity::valid) continue;
    ++(std::abs(z - alone.z.begin()[i]) < 0.01 ? same : wrong);
  }
  EXPECT_GT(points, 315000);
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(same, 0.98 * points);
  RecordProperty("same", same);
  RecordProperty("points", points);
}

}  // namespace slipstream::depth_range_test
