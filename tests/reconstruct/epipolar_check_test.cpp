// Patterns along both axes in one scan, each pixel held to its epipolar line.
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "reconstruct/epipolar.h"
#include "reconstruct/pipeline.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::epipolar_check_test {

const Sequence both{.strategy = DualFrequency{.steps = 3, .high = 16, .low = 1}, .both_axes = true};

struct TrueScan {
  Scan scan;
  Image<double> depth;
};

/// As it is loaded: the frames along x, those along y beside them; exchanged as `order` says.
TrueScan scan_of(const char* scene, const Scanner& scanner, const Photometry& photometry,
                 const Sequence& sequence = both, const std::vector<int>& order = {}) {
  VirtualScan taken = scan_of_scene(scene, scanner, pattern_set(sequence), photometry);
  if (!order.empty()) taken.frames = reordered(std::move(taken.frames), order);
  return {merged({.frames = std::move(taken.frames), .sequence = sequence, .scanner = scanner}),
          std::move(taken.depth)};
}

Cloud cloud_of(const Scan& scan) {
  Cloud cloud;
  Engine(setup_for(scan)).cloud(scan.frames, cloud);
  return cloud;
}

struct Checked {
  Cloud cloud;
  Maps maps;
  EpipolarCheck check;
};

Checked checked(const Scan& scan, ReconstructSettings settings = {}) {
  const EngineSetup setup = setup_for(scan, settings);
  Checked result;
  Engine(setup).cloud_and_maps(scan.frames, result.cloud, result.maps);
  result.check = check_epipolar(setup, scan.other_axis.front(), result.maps, result.cloud);
  return result;
}

TEST(EpipolarCheck, EpipolarDistanceIsNothingWithoutNoise) {
  const Scanner scanner = example_scanner({160, 120});
  for (const Strategy& strategy :
       {Strategy(DualFrequency{.steps = 4, .low_steps = 3, .high = 16, .low = 1}),
        Strategy(PhaseMeasuring{.steps = 5, .frequency = 1})}) {
    const Sequence sequence{.strategy = strategy, .both_axes = true};
    const auto [scan, depth] = scan_of("boxes", scanner, {.bits = std::nullopt}, sequence);
    const Scan& other = scan.other_axis.front();
    const ReferenceEngine along_x({scanner, scan.sequence, {}}, {});
    const ReferenceEngine along_y({scanner, other.sequence, {}}, {});
    const auto [cloud, maps] = along_x(scan.frames);
    const BasicMaps<double> other_maps = along_y.maps(other.frames);
    int points = 0;
    for (int row = 0; row < cloud.size().height; ++row) {
      for (int column = 0; column < cloud.size().width; ++column) {
        if (cloud.validity(column, row) != Validity::valid) continue;
        ++points;
        ASSERT_NEAR(cloud.z(column, row), depth(column, row), 1e-6);
        const auto [distance, normal] =
            epipolar_distance(scanner, ray_through(scanner.camera, {column, row}),
                              maps.coordinate(column, row), other_maps.coordinate(column, row));
        ASSERT_LT(std::abs(distance), 1e-6);
        ASSERT_NEAR(normal.norm(), 1, 1e-12);
      }
    }
    EXPECT_GT(points, 1500);
  }
}

TEST(EpipolarCheck, EpipolarDistanceIsThatOfThePixelAcrossTheLine) {
  Scanner scanner = example_scanner({160, 120});
  scanner.projector.distortion = {};
  const auto [width, height] = scanner.projector.size;
  const Eigen::Vector3d ray = ray_through(scanner.camera, {70, 50});
  const Eigen::Vector2d pixel = project(scanner.projector, in_projector_frame(scanner, 600 * ray));
  const auto at = [&](const Eigen::Vector2d& place) {
    return epipolar_distance(scanner, ray, place.x() / width, place.y() / height);
  };
  const Eigen::Vector2d normal = at(pixel).normal;
  EXPECT_NEAR(at(pixel + 3 * normal).distance, 3, 1e-9);
  EXPECT_NEAR(at(pixel - 2 * normal).distance, -2, 1e-9);
  EXPECT_NEAR(at(pixel + Eigen::Vector2d(-normal.y(), normal.x())).distance, 0, 1e-9);
}

TEST(EpipolarCheck, BothAxesGiveTheCloudOfTheFirst) {
  const Scanner scanner = example_scanner({320, 240});
  const Photometry photometry{.ambient = 5, .noise_variance = 1.6};
  const TrueScan taken = scan_of("statue", scanner, photometry);
  ASSERT_EQ(taken.scan.frames.count(), 6);
  ASSERT_EQ(taken.scan.other_axis.front().sequence, along(both, Axis::y));
  const Checked result = checked(taken.scan);
  const Cloud alone = cloud_of(scan_of("statue", scanner, photometry, along(both, Axis::x)).scan);
  int points = 0, other = 0;
  for (std::size_t i = 0; i < alone.z.pixel_count(); ++i) {
    if (alone.validity.begin()[i] != Validity::valid) continue;
    ++points;
    if (result.cloud.z.begin()[i] != alone.z.begin()[i]) ++other;
  }
  EXPECT_FALSE(result.check.contradicts(0));
  EXPECT_FALSE(result.check.is_off(0));
  EXPECT_LT(std::abs(result.check.median), 0.01);
  EXPECT_NEAR(result.check.median_length, 0.6745 * result.check.median_sigma,
              0.1 * result.check.median_sigma);
  EXPECT_GT(points, 20000);
  EXPECT_LT(other, 0.005 * points);
}

/// The scanner after its projector turned by an angle, degrees, about an axis of its frame.
Scanner turned(const Scanner& scanner, double degrees, int axis) {
  Scanner result = scanner;
  const double angle = degrees * std::numbers::pi / 180;
  result.rotation = Eigen::AngleAxisd(angle, Eigen::Vector3d::Unit(axis)) * scanner.rotation;
  return result;
}

/// Errors of calibrations of RMS 0.5 to 1 pixel move all points alike and contradict none.
TEST(EpipolarCheck, BothAxesKeepThePointsOfAnOrdinaryCalibration) {
  const Scanner scanner = example_scanner({320, 240});
  Scan scan = scan_of("board", scanner, {.noise_variance = 1.6}).scan;
  const std::size_t all = point_count(checked(scan).cloud);

  std::vector<Scanner> errors(5, scanner);
  errors[0].projector.intrinsic(1, 2) += 0.75;
  errors[1].projector.intrinsic(1, 2) -= 1.5;
  errors[2].projector.intrinsic(1, 1) *= 1.004;
  errors[3] = turned(scanner, 0.06, 0);
  errors[4] = turned(scanner, 0.1, 2);
  for (Scanner& error : errors) {
    scan.scanner = error;
    const auto [cloud, maps, check] = checked(scan);
    EXPECT_GE(point_count(cloud), 0.99 * static_cast<double>(all)) << &error - errors.data();
    EXPECT_TRUE(check.is_off(0)) << check.common;
    EXPECT_FALSE(check.contradicts(0)) << check.common;
    EXPECT_FALSE(check.is_off(1)) << check.common;
  }
}

TEST(EpipolarCheck, BothAxesKeepThePointsOfASmallObjectInALargePicture) {
  Scan scan = scan_of("board", example_scanner({480, 360}), {.noise_variance = 1.6}).scan;
  scan.scanner->projector.intrinsic(1, 2) += 1.5;

  const EngineSetup setup = setup_for(scan);
  Cloud whole;
  Maps maps;
  Engine(setup).cloud_and_maps(scan.frames, whole, maps);

  for (const int half : {4, 9}) {
    Cloud cloud = whole;
    for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
      const bool is_on_object = std::abs(column - 240) < half && std::abs(row - 180) < half;
      if (!is_on_object) cloud.reject(column, row, Validity::too_dark);
    });

    const std::size_t all = point_count(cloud);
    ASSERT_GT(all, 40U);
    const EpipolarCheck check = check_epipolar(setup, scan.other_axis.front(), maps, cloud);
    EXPECT_GE(point_count(cloud), 0.97 * static_cast<double>(all));
    EXPECT_TRUE(check.is_off(0)) << check.common;
  }
}

TEST(EpipolarCheck, BothAxesSeeARigThatMoved) {
  const Scanner scanner = example_scanner({320, 240});
  Scan scan = scan_of("board", scanner, {.noise_variance = 1.6}).scan;
  for (const int axis : {0, 1, 2}) {
    scan.scanner = turned(scanner, 1, axis);
    const EpipolarCheck check = checked(scan).check;
    EXPECT_TRUE(check.contradicts(0.6)) << axis << ": " << check.common;
    EXPECT_GT(check.median_length, 3);
  }
}

/// Whichever two of the frames are exchanged: if the axes do not contradict each other, what is
/// still shown is as far off as half a projector pixel makes it.
TEST(EpipolarCheck, BothAxesShowNoWrongPointOfExchangedFrames) {
  const Scanner scanner = example_scanner({160, 120});
  std::size_t wrong_before = 0;
  for (int a = 0; a < 12; ++a) {
    for (int b = a + 1; b < 12; ++b) {
      std::vector<int> order(12);
      std::iota(order.begin(), order.end(), 0);
      std::swap(order[static_cast<std::size_t>(a)], order[static_cast<std::size_t>(b)]);
      const auto [scan, depth] = scan_of("boxes", scanner, {.noise_variance = 1.6}, both, order);
      const auto [cloud, maps, check] = checked(scan);
      const Cloud along_x = cloud_of(scan);
      for (std::size_t i = 0; i < depth.pixel_count(); ++i) {
        wrong_before += std::abs(along_x.z.begin()[i] - depth.begin()[i]) > 3 ? 1 : 0;
        if (check.contradicts(0) || cloud.validity.begin()[i] != Validity::valid) continue;
        ASSERT_LT(std::abs(cloud.z.begin()[i] - depth.begin()[i]), 3) << a << ", " << b;
      }
    }
  }
  EXPECT_GT(wrong_before, 50000U);
}

TEST(EpipolarCheck, BothAxesAreNotTakenWhereOneIsExpected) {
  const Scanner scanner = example_scanner({160, 120});
  EXPECT_THROW(Engine(scanner, both), Error);
  const Sequence fine{.strategy = PhaseMeasuring{.steps = 3, .frequency = 4}, .both_axes = true};
  const Scan scan = scan_of("board", scanner, {}, fine).scan;
  const EngineSetup setup = setup_for(scan, {.nearest = 560, .farthest = 640});
  Maps maps;
  Cloud cloud;
  EXPECT_THROW(check_epipolar(setup, scan.other_axis.front(), maps, cloud), Error);
}

}  // namespace slipstream::epipolar_check_test
