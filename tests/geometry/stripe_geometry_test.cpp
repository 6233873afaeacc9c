#include "geometry/stripe_geometry.h"

#include <cmath>

#include <gtest/gtest.h>

#include "geometry/ray_blocks.h"
#include "geometry/ray_table.h"
#include "geometry/triangulator.h"
#include "slipstream/error.h"
#include "tests/geometry/depth_on_ray.h"
#include "tests/geometry/random_scanner.h"

namespace slipstream::stripe_geometry_test {

/// Every 40th pixel and 19 coordinates of a scanner against Triangulator, which iterates.
void expect_depths_of_triangulator(const Scanner& scanner, Axis axis) {
  constexpr double margin = 0.02;
  const auto geometry = stripe_geometry(scanner, axis, margin);
  ASSERT_TRUE(geometry && !geometry->solved);
  const Triangulator triangulate(scanner, axis, PointMethod::inverse);
  const Axis across = axis == Axis::x ? Axis::y : Axis::x;
  int points = 0;
  for (int row = 0; row < scanner.camera.size.height; row += 40) {
    for (int column = 0; column < scanner.camera.size.width; column += 40) {
      const Eigen::Vector3d ray = ray_through(scanner.camera, {column, row});
      const double at_infinity =
          geometry->coordinate.head<3>().dot(ray) / geometry->depth.head<3>().dot(ray);
      for (double y = 0.05; y < 1; y += 0.05) {
        if (std::abs(at_infinity - y) < 0.1) continue;
        const auto depth = depth_on_ray(*geometry, ray.x(), ray.y(), y);
        const Eigen::Vector3d point = triangulate(column, row, y);
        const Eigen::Vector3d seen = in_projector_frame(scanner, point);
        if (!(point.z() > 0 && seen.z() > 0)) continue;
        EXPECT_EQ(depth.before_projector, seen.z() > 0);
        const double place =
            coordinate_along(across, project(scanner.projector, seen), scanner.projector.size);
        const bool at_the_edge =
            std::min(std::abs(place + margin), std::abs(place - 1 - margin)) < 1e-3;
        const bool in_field = place > -margin && place < 1 + margin;
        if (!at_the_edge && std::abs(place - 0.5) < 1) EXPECT_EQ(depth.in_field, in_field) << place;
        if (!in_field) continue;
        EXPECT_NEAR(depth.z / point.z(), 1, 4e-6) << "column " << column << ", y " << y;
        ++points;
      }
    }
  }
  EXPECT_GT(points, 100);
}

TEST(StripeGeometry, GivesTheDepthsOfTheTriangulator) {
  int geometries = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Scanner scanner = random_scanner(seed, seed % 4 == 0 ? 0 : 0.08);
    for (const Axis axis : {Axis::x, Axis::y}) {
      // Along the other axis the baseline is too short for most of these.
      const Eigen::Vector3d& T = scanner.translation;
      const bool along = std::abs(axis == Axis::x ? T.x() : T.y()) > 0.7 * T.norm();
      const auto geometry = stripe_geometry(scanner, axis, 0.02);
      if (!along || !geometry || geometry->solved) continue;
      SCOPED_TRACE(testing::Message() << "scanner " << seed << ", axis " << name_of(axis));
      expect_depths_of_triangulator(scanner, axis);
      ++geometries;
    }
  }
  EXPECT_GE(geometries, 12);
}

TEST(StripeGeometry, SolvesALensThatBendsMuchUnlessItTurnsBack) {
  Scanner scanner = random_scanner(1);
  scanner.projector.intrinsic(0, 0) = scanner.projector.intrinsic(1, 1) = 500;
  scanner.projector.distortion = make_distortion(std::array{-0.5, 0.3, 0.0, 0.0});
  const auto geometry = stripe_geometry(scanner, Axis::x, 0.02);
  ASSERT_TRUE(geometry && geometry->solved);
  EXPECT_FALSE(ray_blocks(*geometry, ray_table(scanner.camera).value()));
  scanner.projector.distortion = make_distortion(std::array{-0.5, 0.0, 0.0, 0.0});
  EXPECT_FALSE(stripe_geometry(scanner, Axis::x, 0.02));
}

TEST(StripeGeometry, RefusesAScannerThatSeesNoDepth) {
  Scanner scanner = random_scanner(1);
  scanner.translation = {0, 100, 0};
  EXPECT_THROW(stripe_geometry(scanner, Axis::x, 0.02), Error);
}

}  // namespace slipstream::stripe_geometry_test
