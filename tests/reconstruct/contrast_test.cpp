// The camera's blur pulls coordinates at edges of print. The correction takes the pull back where
// there is one, and changes nothing else.
#include "reconstruct/contrast.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include "io/scan_pictures.h"
#include "reconstruct/coordinate_map.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/gray_code.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"
#include "tests/shared_data.h"

namespace slipstream::contrast_test {
namespace fs = std::filesystem;

/// A printed chessboard that fills most of the view, tilted against the baseline.
Scene chessboard(const Scanner& scanner) {
  constexpr int squares = 11, wide = 20;  // picture pixels a square
  Image<std::uint8_t> picture({squares * wide, squares * wide});
  for_each_pixel_in_order(picture.size(), [&](int column, int row) {
    picture(column, row) = (column / wide + row / wide) % 2 == 0 ? 255 : 0;
  });

  const WorkingVolume volume = working_volume(scanner);
  Body sheet = printed_sheet(picture, volume.extent / picture.width(), scanner);
  sheet.pose.translation() = volume.centre;
  sheet.pose.rotate(Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 1, 0).normalized()));
  return {sheet};
}

VirtualWorld world_of(std::string_view photometry, Size camera) {
  VirtualWorld world{.scanner = example_scanner(camera)};
  world.photometry = photometry_named(photometry);
  world.scene = chessboard(world.scanner);
  return world;
}

/// Errors of the points that the correction moved, RMS.
struct Comparison {
  Cloud plain, corrected;
  Maps maps;  ///< corrected
  int moved = 0;
  double before = 0, after = 0;  ///< mm
  double in_sigma = 0;           ///< after, in standard deviations of each point
};

Comparison compared(const VirtualWorld& world, const Strategy& strategy,
                    EngineKind kind = EngineKind::automatic) {
  const Sequence sequence{.strategy = strategy, .projector = world.scanner.projector.size};
  const Scanner scanner = as_calibrated(world);
  const VirtualScan scan =
      take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);

  // 1. The clouds.
  Comparison result;
  Engine(scanner, sequence, {.engine = kind}).cloud(scan.frames, result.plain);
  Engine correct(scanner, sequence, {.engine = kind, .correct_contrast = true});
  correct.cloud_and_maps(scan.frames, result.corrected, result.maps);
  const Uncertainty sigma = correct.uncertainty(result.corrected, result.maps, scan.frames);

  // 2. The points that moved, but for wrong fringe orders.
  constexpr double wrong_order = 8;  // mm
  double before = 0, after = 0, in_sigma = 0;
  for_each_pixel_in_order(scan.depth.size(), [&](int column, int row) {
    const double was = result.plain.z(column, row) - scan.depth(column, row);
    const double is = result.corrected.z(column, row) - scan.depth(column, row);
    if (!(std::abs(was) < wrong_order && std::abs(is) < wrong_order) || was == is) return;
    before += was * was;
    after += is * is;
    in_sigma += std::pow(is / sigma.z(column, row), 2);
    ++result.moved;
  });

  const auto rms = [&](double squares) { return std::sqrt(squares / std::max(result.moved, 1)); };
  result.before = rms(before);
  result.after = rms(after);
  result.in_sigma = rms(in_sigma);
  return result;
}

const Strategy fine = DualFrequency{.steps = 8, .high = 64};

TEST(Contrast, ErrorsAtEdgesOfPrintAreAFewTimesLess) {
  struct Case {
    const char* world;
    int periods;
    double times;
  };
  for (const auto& [world, periods, times] : {Case{"bench", 64, 3},
                                              {"bench", 32, 2},
                                              {"bench", 16, 1.3},
                                              {"bench,camera-blur", 64, 3},
                                              {"harsh", 64, 2.5}}) {
    for (const EngineKind kind : {EngineKind::fused, EngineKind::reference}) {
      const Comparison found = compared(world_of(world, {640, 480}),
                                        DualFrequency{.steps = 8, .high = double(periods)}, kind);
      EXPECT_GT(found.moved, 5000) << world;
      EXPECT_LT(found.after, found.before / times) << world << ", " << periods;

      // What is left is within the points' standard deviations.
      EXPECT_GT(found.in_sigma, 0.6) << world << ", " << periods;
      EXPECT_LT(found.in_sigma, 1.4) << world << ", " << periods;
      if (kind == EngineKind::reference) continue;
      std::printf("%s, %d periods: %d points, %.3f to %.3f mm, %.2f sigma\n", world, periods,
                  found.moved, found.before, found.after, found.in_sigma);
    }
  }
}

TEST(Contrast, CorrectionMakesNoStillSceneWorse) {
  for (const char* const world : {"bench", "bench,camera-blur"}) {
    for (const std::string_view scene : scene_names()) {
      VirtualWorld rig = world_of(world, {320, 240});
      rig.scene = scene_named(scene, rig.scanner);
      // The hand moves, which no edge of print explains; it takes long, and is worst at 8.
      const bool moves = scene == "hand";
      for (const int high : {8, 16, 32, 64}) {
        if (moves && high > 8) continue;
        const Comparison found = compared(rig, DualFrequency{.steps = 4, .high = double(high)});
        EXPECT_LE(found.after, (moves ? 1.15 : 1.02) * found.before)
            << world << ", " << scene << ", " << high;
      }
    }
  }
}

TEST(Contrast, OfAPlainSurfaceChangesNothing) {
  VirtualWorld rig = world_of("bench", {320, 240});
  rig.scene = scene_named("sphere", rig.scanner);
  const Comparison found = compared(rig, fine);
  EXPECT_EQ(found.moved, 0);
  EXPECT_EQ(std::ranges::count(found.maps.contrast, 0.F),
            static_cast<std::ptrdiff_t>(found.maps.contrast.pixel_count()));
}

TEST(Contrast, OfAMapIsThatOfItsFrames) {
  const VirtualWorld rig = world_of("bench", {320, 240});
  const Sequence sequence{.strategy = fine, .projector = rig.scanner.projector.size};
  const Scanner scanner = as_calibrated(rig);
  const VirtualScan scan = take_scan(rig.scanner, rig.scene, pattern_set(sequence), rig.photometry);

  // Frames say why a pixel has no point, a map does not: pixels without one are left out of it.
  const CleanSettings clean = CleanSettings::none();
  Engine engine(scanner, sequence, {.clean = clean});
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(scan.frames, cloud, maps);
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) maps.coordinate(column, row) = NAN;
  });

  const EngineSetup setup{scanner, sequence, {.correct_contrast = true, .clean = clean}};
  const Cloud of_map =
      cloud_of_coordinates(converted<double>(maps.coordinate), setup, maps.modulation);
  Cloud of_frames;
  Engine(setup).cloud(scan.frames, of_frames);
  int compared = 0, off = 0;
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    const float difference = std::abs(of_map.z(column, row) - of_frames.z(column, row));
    if (std::isnan(difference)) return;
    ++compared;
    off += difference > 0.01F ? 1 : 0;
  });
  EXPECT_GT(compared, 20'000);
  EXPECT_LT(off, compared / 1000);

  EXPECT_THROW(cloud_of_coordinates(converted<double>(maps.coordinate), setup), Error);
}

/// The terms of a polynomial of degree 4 at a pixel, both coordinates up to about 1.
Eigen::Vector<double, 15> terms_at(int column, int row) {
  const double x = column / 500.0 - 1, y = row / 500.0 - 1;
  Eigen::Vector<double, 15> terms;
  int n = 0;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; j <= 4 - i; ++j) terms[n++] = std::pow(x, i) * std::pow(y, j);
  }
  return terms;
}

/// The dots of a flat board are no relief: the phase is a smooth surface but for blur and noise.
TEST(Contrast, OfARealBoardOfDotsIsHalvedAtLeast) {
  const fs::path folder = shared_data() / "cpsd-plane";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";

  // 1. The coordinate, and its pull.
  std::vector<fs::path> files;
  for (const fs::path& file : images_in_folder(folder)) {
    if (file.filename().string().starts_with("f")) files.push_back(file);
  }
  const LoadedFrames loaded = read_frames(files);
  const Sequence sequence{.strategy = MultiFrequency{.steps = {12},
                                                     .periods = {1, 4, 16, 64},
                                                     .unwrapping = "hierarchical",
                                                     .shifts = {std::numbers::pi, true}}};
  Scanner scanner;
  scanner.camera.size = loaded.frames.size();
  Engine engine(scanner, sequence);
  Maps maps;
  engine.maps(loaded.frames, maps);
  const Image<Validity> validity =
      picture_report(loaded.frames, maps, engine.setup().settings).validity;
  const ContrastPull found = contrast_pull(maps.coordinate, maps.modulation, validity);

  // 2. A smooth surface through the pixels without one.
  Eigen::Matrix<double, 15, 15> squares = Eigen::Matrix<double, 15, 15>::Zero();
  Eigen::Vector<double, 15> right = Eigen::Vector<double, 15>::Zero();
  const auto phase_at = [&](int column, int row) {
    return 2 * std::numbers::pi * 64 * maps.coordinate(column, row);
  };
  for_each_pixel_in_order(validity.size(), [&](int column, int row) {
    if (validity(column, row) != Validity::valid || found.pull(column, row) != 0) return;
    const Eigen::Vector<double, 15> terms = terms_at(column, row);
    squares += terms * terms.transpose();
    right += phase_at(column, row) * terms;
  });
  const Eigen::Vector<double, 15> surface = squares.ldlt().solve(right);

  // 3. Distances from it where there is a pull.
  double before = 0, after = 0, rest = 0;
  int pulled = 0, others = 0;
  for_each_pixel_in_order(validity.size(), [&](int column, int row) {
    if (validity(column, row) != Validity::valid) return;
    const double pull = 2 * std::numbers::pi * 64 * found.pull(column, row);
    const double off = phase_at(column, row) - surface.dot(terms_at(column, row));
    if (pull == 0) {
      rest += off * off;
      ++others;
    } else {
      before += off * off;
      after += std::pow(off - pull, 2);
      ++pulled;
    }
  });
  const auto rms = [](double sum, int count) { return std::sqrt(sum / count); };
  std::printf("s^2 %.2f; %d of %d pixels pulled: %.4f to %.4f rad; others %.4f rad\n",
              found.variance, pulled, pulled + others, rms(before, pulled), rms(after, pulled),
              rms(rest, others));
  EXPECT_GT(pulled, 10'000);
  EXPECT_LT(rms(after, pulled), rms(before, pulled) / 2);
}

TEST(Contrast, IsRefusedWithoutPhases) {
  const Scanner scanner = example_scanner({320, 240});
  try {
    Engine(scanner, {.strategy = GrayCode{}, .projector = scanner.projector.size},
           {.correct_contrast = true});
    FAIL();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "`correct_contrast` needs phases, which gray does not measure");
  }
}

}  // namespace slipstream::contrast_test
