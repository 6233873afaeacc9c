// Points that light from other surfaces moves are found, and hardly any others.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"

namespace slipstream::reflection_test {

using Vector = Eigen::Vector3d;

Body board_at(const Vector& place, double degrees, const Vector& shift, double width,
              double height) {
  Body board{.shape = Board{width, height}, .shading = Shading::lambertian};
  board.pose.translate(place);
  board.pose.rotate(Eigen::AngleAxisd(degrees * std::numbers::pi / 180, Vector::UnitY()));
  board.pose.translate(shift);
  return board;
}

/// A plate with a V-groove of 90 degrees across its middle.
Scene groove(const Scanner& scanner) {
  const WorkingVolume volume = working_volume(scanner);
  const double half = 0.18 * volume.extent, side = std::sqrt(2.0) * half;
  const double plate = 2 * volume.extent, height = 4 * volume.extent;
  const Vector top = volume.centre - Vector(0, 0, 0.05 * volume.extent);

  Scene scene;
  for (const int sign : {1, -1}) {
    scene.push_back(
        board_at(top + Vector(0, 0, half), sign * 45, Vector(sign * side / 2, 0, 0), side, height));
    scene.push_back(board_at(top, 0, Vector(sign * (half + plate / 2), 0, 0), plate, height));
  }
  return scene;
}

/// A sphere that nearly touches a wall to its right, which is turned towards it by that angle.
Scene sphere_beside_wall(const Scanner& scanner, double degrees) {
  const WorkingVolume volume = working_volume(scanner);
  const double radius = 0.2 * volume.extent, side = 1.2 * volume.extent;
  Body sphere{.shape = Sphere{radius}, .shading = Shading::lambertian};
  sphere.pose.translate(volume.centre);
  const double angle = degrees * std::numbers::pi / 180;
  const Vector towards_wall(std::cos(angle), 0, std::sin(angle));
  const Vector foot = volume.centre + 1.05 * radius * towards_wall;
  return {sphere, board_at(foot, 90 - degrees, Vector(0, 0, 0), side, side)};
}

/// The same light without noise.
Photometry noiseless(Photometry photometry) {
  photometry.bits.reset();
  photometry.noise_variance = 0;
  Physics& physics = photometry.physics;
  physics.full_well = physics.read_noise = physics.row_noise = 0;
  physics.dark_spread = physics.sensitivity_spread = 0;
  return photometry;
}

struct Found {
  int bad = 0, found = 0;  ///< points moved by over 5 sigma; of these, those rejected
  int good = 0, lost = 0;  ///< points that, with those beside them, move by less than 1 sigma
};

Found found_in(const Scene& scene, const Strategy& strategy, const CleanSettings& clean) {
  VirtualWorld world{.scanner = example_scanner({320, 240}),
                     .scene = scene,
                     .photometry = photometry_named("bench")};
  const Sequence sequence{.strategy = strategy, .projector = world.scanner.projector.size};
  const PatternSet patterns = pattern_set(sequence);
  const Scanner scanner = as_calibrated(world);

  // 1. Coordinates without noise, with light from other surfaces and without.
  Engine engine(scanner, sequence);
  Maps alone, lit;
  Photometry light = world.photometry;
  engine.maps(take_scan(scanner, scene, patterns, noiseless(light)).frames, alone);
  light.physics.bounces = 128;
  const VirtualScan scan = take_scan(scanner, scene, patterns, noiseless(light));
  engine.maps(scan.frames, lit);

  // 2. A scan with noise, with the filter and without.
  const FrameSet frames = take_again(scan, patterns, light);
  Cloud cloud, filtered;
  Maps maps;
  engine.cloud_and_maps(frames, cloud, maps);
  const Uncertainty sigma = engine.uncertainty(cloud, maps, frames);
  Engine(scanner, sequence, {.clean = clean}).cloud(frames, filtered);

  Image<float> moved(cloud.size());
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    moved(column, row) = std::abs(lit.coordinate(column, row) - alone.coordinate(column, row)) /
                         sigma.coordinate(column, row);
  });

  // 3. Who is found.
  Found result;
  const int reach = 2;  // pixels: where the light changes sign, a point stands still by chance
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (cloud.validity(column, row) != Validity::valid) return;
    const int found = filtered.validity(column, row) == Validity::reflected ? 1 : 0;
    if (moved(column, row) > 5) {
      ++result.bad;
      result.found += found;
    }

    float largest = 0;
    for (int y = std::max(row - reach, 0); y <= std::min(row + reach, moved.height() - 1); ++y) {
      for (int x = std::max(column - reach, 0); x <= std::min(column + reach, moved.width() - 1);
           ++x) {
        largest = std::max(largest, moved(x, y));
      }
    }
    if (largest < 1) {
      ++result.good;
      result.lost += found;
    }
  });

  std::printf("%d of %d bad points found, %d of %d good ones lost\n", result.found, result.bad,
              result.lost, result.good);
  return result;
}

const Strategy dual = DualFrequency{.steps = 8, .high = 16};

void expect_found(const Found& found, double share) {
  EXPECT_GT(found.bad, 300) << "else this shows nothing";
  EXPECT_GE(found.found, share * found.bad);
  EXPECT_LE(found.lost, 0.02 * found.good);
}

TEST(Reflection, IsFoundInAGroove) {
  const Scene scene = groove(example_scanner({320, 240}));
  expect_found(found_in(scene, dual, {.reflection = 5}), 0.99);
  expect_found(found_in(scene, dual, {.local_reflection = 5}), 0.99);
}

// At 20 degrees and less the light comes from so near that it looks like blur.
TEST(Reflection, IsFoundOfASphereBesideAWall) {
  for (const double degrees : {25.0, 30.0}) {
    const Scene scene = sphere_beside_wall(example_scanner({320, 240}), degrees);
    expect_found(found_in(scene, dual, {.reflection = 5}), 0.98);
    expect_found(found_in(scene, dual, {.local_reflection = 5}), 0.95);
  }
}

/// Share of the points of a scan without light from other surfaces that the filter rejects.
double lost_share(const char* scene, const Strategy& strategy) {
  VirtualWorld world = virtual_world({.scene = scene, .camera = {320, 240}});
  const Sequence sequence{.strategy = strategy, .projector = world.scanner.projector.size};
  const FrameSet frames =
      take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry).frames;

  Cloud cloud;
  Engine(as_calibrated(world), sequence, {.clean = {.reflection = 5, .local_reflection = 5}})
      .cloud(frames, cloud);
  const double lost =
      static_cast<double>(count_by_validity(cloud)[static_cast<std::size_t>(Validity::reflected)]);
  const double share = lost / (lost + static_cast<double>(point_count(cloud)));
  std::printf("%s: %.2f %% of the points rejected\n", scene, 100 * share);
  return share;
}

TEST(Reflection, IsNotFoundWhereNoSurfaceLightsAnother) {
  for (const char* const scene : {"board", "sphere", "statue", "boxes", "fish", "angel"}) {
    EXPECT_LT(lost_share(scene, dual), 0.021) << scene;
  }
}

TEST(Reflection, NeedsABandOfFewPeriodsThatBlurDimsLikeTheFinest) {
  const Scanner scanner = example_scanner({80, 60});
  const Sequence sequence{.strategy = MultiFrequency{.periods = {64, 56, 49}}};
  EXPECT_THROW(Engine(scanner, sequence, {.clean = {.reflection = 5}}), Error);
  EXPECT_NO_THROW(Engine(scanner, sequence));

  const Sequence fine{.strategy = DualFrequency{.high = 64}};
  EXPECT_THROW(Engine(scanner, fine, {.clean = {.reflection = 5}}), Error);
}

}  // namespace slipstream::reflection_test
