// Blocks of rays and depths against the geometry that they stand for.
#include "geometry/ray_table.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "geometry/ray_blocks.h"
#include "geometry/stripe_geometry.h"
#include "slipstream/named_scenes.h"
#include "tests/geometry/depth_on_ray.h"
#include "tests/geometry/random_scanner.h"

namespace slipstream::ray_table_test {

double worst_miss(const Lens& camera, const RayTable& table) {
  double worst = 0;
  const auto next = [](int i, int length) {
    return i + 3 < length ? i + 3 : std::max(i + 1, length - 1);
  };
  for (int row = 0; row < camera.size.height; row = next(row, camera.size.height)) {
    for (int column = 0; column < camera.size.width; column = next(column, camera.size.width)) {
      const Eigen::Vector3d ray = ray_through(camera, {column, row});
      worst = std::max({worst, std::abs(table.E_x(column, row) - ray.x()),
                        std::abs(table.E_y(column, row) - ray.y())});
    }
  }
  return worst;
}

TEST(RayTable, HoldsTheRays) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Lens camera = random_scanner(seed, 0.12).camera;
    for (const Size size : {Size{640, 480}, Size{643, 477}, Size{641, 481}, Size{33, 25},
                            Size{40, 31}, Size{16, 1}}) {
      camera.size = size;
      const auto table = ray_table(camera);
      ASSERT_TRUE(table);
      EXPECT_LE(worst_miss(camera, *table), 2e-7) << "scanner " << seed << ", " << size.width;
    }
  }
}

/// Interpolated rays take a small part of the time of exact ones, from which rounding tells them.
TEST(RayTable, InterpolatesTheRaysOfUsualLenses) {
  int interpolated = 0;
  for (const double focal : {400.0, 500.0, 600.0, 800.0}) {
    Lens camera{.distortion = make_distortion(std::array{-0.1, 0.02, 0.0, 0.0}),
                .size = {640, 480}};
    camera.intrinsic << focal, 0, 320, 0, focal, 240, 0, 0, 1;
    const RayTable table = ray_table(camera).value();
    for (int column = 0; column < 640; ++column) {
      const Eigen::Vector3d ray = ray_through(camera, {column, 3});
      if (table.E_x(column, 3) != static_cast<float>(ray.x())) ++interpolated;
    }
  }
  EXPECT_GT(interpolated, 20);
}

TEST(RayTable, HoldsTheRaysOfALensThatBendsMuch) {
  Lens camera;
  camera.size = {160, 120};
  camera.intrinsic << 80, 0, 80, 0, 80, 60, 0, 0, 1;
  camera.distortion = make_distortion(std::array{-0.1, 0.02, 1e-3, -1e-3, 0.0});
  const auto table = ray_table(camera);
  ASSERT_TRUE(table);
  EXPECT_LE(worst_miss(camera, *table), 2e-7);
}

TEST(RayTable, IsNoneWhereAPixelHasNoRay) {
  Lens camera;
  camera.size = {160, 120};
  camera.intrinsic << 80, 0, 80, 0, 80, 60, 0, 0, 1;
  camera.distortion = make_distortion(std::array{-0.5, 0.0, 0.0, 0.0});
  EXPECT_FALSE(ray_table(camera));
}

double coefficient(const RayBlocks::Row& row, int block, int i) {
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    sum += row.weights[k] * double{row.knots[k][block].coefficients[static_cast<std::size_t>(i)]};
  }
  return sum;
}

double inverse_depth(const RayBlocks::Row& row, int block, double t, double p) {
  double sum = 0;
  int i = 0;
  double power_of_t = 1;
  for (const int terms :
       {RayBlocks::constants, RayBlocks::slopes, RayBlocks::bends, RayBlocks::twists}) {
    for (int k = 0; k < terms; ++k)
      sum += power_of_t * std::pow(p, k) * coefficient(row, block, i++);
    power_of_t *= t;
  }
  return sum;
}

/// Looks at points of every ninth row all over the blocks' ranges. Returns how many there are.
int check(const Scanner& scanner, Axis axis) {
  const auto geometry = stripe_geometry(scanner, axis, 0.02);
  const auto rays = ray_table(scanner.camera);
  if (!geometry || !rays) return 0;
  const auto blocks = ray_blocks(*geometry, *rays);
  if (!blocks) return 0;
  const Size size = scanner.camera.size;
  int points = 0;
  double worst = 0;      // of 1/Z, against all that it changes over the field
  double worst_ray = 0;  // of E_x and E_y
  for (int row = 0; row < size.height; row += 9) {
    const RayBlocks::Row known = blocks->at(row);
    for (int block = 0; block < blocks->knots.width(); ++block) {
      const RayBlocks::Range range = known.described[block];
      if (range.least >= range.largest) continue;
      for (const int i : {0, 5, 13, 24, RayBlocks::width - 1}) {
        const int column = RayBlocks::first_column(block, size.width) + i;
        const double t = (2 * i + 1.0) / RayBlocks::width - 1;
        const auto at = [&](double p) {
          return depth_on_ray(*geometry, rays->E_x(column, row), rays->E_y(column, row),
                              geometry->unit_coordinate.inverse(p));
        };
        const double span = std::abs(1 / at(1).z - 1 / at(-1).z);
        for (const double share : {1e-6, 0.3, 0.6, 1 - 1e-6}) {
          const double p = std::lerp(double{range.least}, double{range.largest}, share);
          const DepthOnRay exact = at(p);
          EXPECT_TRUE(exact.in_field && exact.z > 0 && exact.before_projector)
              << column << ' ' << row << ' ' << p;
          const double inverse = inverse_depth(known, block, t, p);
          EXPECT_GT(inverse, 0);
          worst = std::max(worst, std::abs(inverse - 1 / exact.z) / span);
          ++points;
        }
        const auto cubic = [&](int first) {
          double sum = 0;
          for (int k = RayBlocks::ray_terms - 1; k >= 0; --k) {
            sum = sum * t + coefficient(known, block, first + k);
          }
          return sum;
        };
        worst_ray =
            std::max({worst_ray, std::abs(cubic(RayBlocks::Block::E_x) - rays->E_x(column, row)),
                      std::abs(cubic(RayBlocks::Block::E_y) - rays->E_y(column, row))});
      }
    }
  }
  EXPECT_LE(worst, 1e-6);
  EXPECT_LE(worst_ray, 2.5e-7);
  return points;
}

TEST(RayTable, RayBlocksSayWhatTheGeometrySays) {
  const Scanner scanner = example_scanner({653, 478});
  for (const Axis axis : {Axis::x, Axis::y}) EXPECT_GT(check(scanner, axis), 10000);
}

TEST(RayTable, RayBlocksAreRightForAnyScanner) {
  int points = 0;
  for (unsigned seed = 0; seed < 100 && !HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const Scanner scanner = random_scanner(seed, seed % 4 == 0 ? 0 : 0.08);
    points += check(scanner, seed % 2 == 0 ? Axis::x : Axis::y);
  }
  EXPECT_GT(points, 100 * 1000);
}

/// A camera that sees twice as wide as the projector lights: rays diverge within a block.
TEST(RayTable, RayBlocksAreRightInNarrowPictures) {
  for (const int width : {32, 40, 48}) {
    SCOPED_TRACE(width);
    Scanner scanner;
    scanner.camera.size = {width, 64};
    scanner.camera.intrinsic << 0.5 * width, 0, 0.5 * width, 0, 80, 32, 0, 0, 1;
    scanner.projector.size = {1000, 1000};
    scanner.projector.intrinsic << 1000, 0, 1200, 0, 1000, 500, 0, 0, 1;
    scanner.translation = {-100, 0, 0};
    EXPECT_GT(check(scanner, Axis::x), 100);
  }
}

TEST(RayTable, RayBlocksAreNotForSmallPictures) {
  const Scanner scanner = example_scanner({64, 25});
  const auto geometry = stripe_geometry(scanner, Axis::x, 0.02);
  EXPECT_FALSE(ray_blocks(*geometry, *ray_table(scanner.camera)));
}

}  // namespace slipstream::ray_table_test
