#include "slipstream/geometry/triangulator.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "tests/geometry/random_scanner.h"

namespace slipstream::triangulator_test {

class TriangulatorBy : public testing::TestWithParam<PointMethod> {};

TEST_P(TriangulatorBy, FindsThePointThroughBothLenses) {
  for (const double distortion : {0.0, 0.15}) {
    for (const Axis axis : {Axis::x, Axis::y}) {
      for (unsigned seed = 0; seed < 6; ++seed) {
        const Scanner scanner = random_scanner(seed, distortion, {80, 60});
        const Triangulator triangulate(scanner, axis, GetParam());
        for (int row = 7; row < 60; row += 15) {
          for (int column = 10; column < 80; column += 20) {
            const double depth = 250 + 24 * row;
            const Eigen::Vector3d point = depth * ray_through(scanner.camera, {column, row});
            const Eigen::Vector2d pixel =
                project(scanner.projector, in_projector_frame(scanner, point));
            const double y = coordinate_along(axis, pixel, scanner.projector.size);
            if (!(y >= 0 && y < 1)) continue;
            ASSERT_LT((triangulate(column, row, y) - point).norm(), 1e-6)
                << "seed " << seed << " pixel " << column << ", " << row;
          }
        }
      }
    }
  }
}

std::string method_name(const testing::TestParamInfo<PointMethod>& info) {
  static constexpr std::array names{"inverse", "form1", "form2", "form3"};
  return names[static_cast<std::size_t>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Method, TriangulatorBy,
                         testing::Values(PointMethod::inverse, PointMethod::form1,
                                         PointMethod::form2, PointMethod::form3),
                         method_name);

TEST(Triangulator, RefusesSingularCalibrations) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto expect_refused = [](const Scanner& scanner, Axis axis = Axis::x) {
    EXPECT_THROW(Triangulator(scanner, axis, PointMethod::form3), Error);
  };
  Scanner scanner = random_scanner(1);
  scanner.translation.setZero();
  expect_refused(scanner);

  scanner = random_scanner(1);
  scanner.translation.x() = nan;
  expect_refused(scanner);

  scanner = random_scanner(1);
  scanner.rotation.row(0) *= -1;
  expect_refused(scanner);

  scanner = random_scanner(1);
  scanner.camera.intrinsic(1, 1) = 0;
  expect_refused(scanner);

  scanner = random_scanner(1);
  scanner.projector.size = {};
  expect_refused(scanner);

  scanner = random_scanner(1);
  scanner.rotation.setIdentity();
  scanner.translation = {100, 0, 0};
  expect_refused(scanner, Axis::y);
  EXPECT_NO_THROW(Triangulator(scanner, Axis::x, PointMethod::form3));
}

}  // namespace slipstream::triangulator_test
