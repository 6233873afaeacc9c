#include "geometry/triangulator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "slipstream/error.h"
#include "tests/geometry/random_scanner.h"

namespace slipstream::triangulator_test {

using Matrix34 = Eigen::Matrix<double, 3, 4>;

/// Random perspective matrices in a world frame that is not the camera's, so that no coefficient of
/// the forms is zero.
ProjectionMatrices random_matrices(unsigned seed, Axis axis) {
  ProjectionMatrices matrices = projection_matrices(random_scanner(seed), axis);
  std::mt19937 random(seed + 1);
  std::uniform_real_distribution<double> angle(-1, 1), shift(-200, 200);
  Eigen::Isometry3d world = Eigen::Isometry3d::Identity();
  world.translate(Eigen::Vector3d(shift(random), shift(random), shift(random)));
  world.rotate(Eigen::AngleAxisd(angle(random), Eigen::Vector3d(1, 2, 3).normalized()));
  matrices.camera = matrices.camera * world.matrix();
  matrices.projector_coordinate = matrices.projector_coordinate * world.matrix();
  matrices.projector_depth = matrices.projector_depth * world.matrix();
  return matrices;
}

double relative_difference(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return (a - b).norm() / b.norm();
}

RC_GTEST_PROP(TriangulatorPointForms, GiveThePointsOfEquation115, ()) {
  const auto seed = *rc::gen::arbitrary<unsigned>();
  const Axis axis = *rc::gen::element(Axis::x, Axis::y);
  const ProjectionMatrices matrices = random_matrices(seed, axis);
  const PointCoefficients coefficients = point_coefficients(matrices);
  for (double x = 0; x < 640; x += 71.3) {
    for (double y = 0; y < 480; y += 67.1) {
      const PointForm1 form1 = point_form1(coefficients, x, y);
      const PointForm3 form3 = point_form3(coefficients, x, y);
      for (const double y_p : {0.03, 0.31, 0.72, 0.98}) {
        const Eigen::Vector3d exact = triangulate(matrices, x, y, y_p);
        // A ray almost parallel to a stripe's plane meets it beyond any scene: kilometres are one
        // over a difference of which rounding leaves few digits.
        const double tolerance = 1e-9 * std::max(1.0, exact.norm() / 1e7);
        RC_ASSERT(relative_difference(form1(y_p), exact) < tolerance);
        RC_ASSERT(relative_difference(form3(y_p), exact) < tolerance);
      }
    }
  }
}

RC_GTEST_PROP(TriangulatorRays, FindsThePointThatBothDevicesSee, ()) {
  const auto seed = *rc::gen::arbitrary<unsigned>();
  const Axis axis = *rc::gen::element(Axis::x, Axis::y);
  const ProjectionMatrices m = random_matrices(seed, axis);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-300, 300);
  const Eigen::Vector4d point(place(random), place(random), place(random), 1);
  const Eigen::Vector3d in_camera = m.camera * point;
  const double y_p = (m.projector_coordinate * point).value() / (m.projector_depth * point).value();
  RC_PRE(std::abs(in_camera.z()) > 100);
  const Eigen::Vector3d found =
      triangulate(m, in_camera.x() / in_camera.z(), in_camera.y() / in_camera.z(), y_p);
  RC_ASSERT((found - point.head<3>()).norm() < 1e-6);
}

TEST(TriangulatorPointForms, HaveTheCoefficientsOfThePrint) {
  // One of each letter of Section 2.1, spelled out; indices as printed, from 1.
  const ProjectionMatrices matrices = random_matrices(5, Axis::y);
  const auto c = [&](int row, int column) { return matrices.camera(row - 1, column - 1); };
  const auto p = [&](int row, int column) {
    return row == 2 ? matrices.projector_coordinate(column - 1)
                    : matrices.projector_depth(column - 1);
  };
  const double a_x1 = c(2, 2) * c(3, 4) * p(3, 3) + c(2, 3) * c(3, 2) * p(3, 4) +
                      c(2, 4) * c(3, 3) * p(3, 2) - c(2, 2) * c(3, 3) * p(3, 4) -
                      c(2, 3) * c(3, 4) * p(3, 2) - c(2, 4) * c(3, 2) * p(3, 3);
  const double b_z3 = c(1, 1) * c(2, 2) * p(2, 4) + c(1, 2) * c(2, 4) * p(2, 1) +
                      c(1, 4) * c(2, 1) * p(2, 2) - c(1, 1) * c(2, 4) * p(2, 2) -
                      c(1, 2) * c(2, 1) * p(2, 4) - c(1, 4) * c(2, 2) * p(2, 1);
  const double c_2 = c(1, 1) * c(3, 3) * p(3, 2) + c(1, 2) * c(3, 1) * p(3, 3) +
                     c(1, 3) * c(3, 2) * p(3, 1) - c(1, 1) * c(3, 2) * p(3, 3) -
                     c(1, 2) * c(3, 3) * p(3, 1) - c(1, 3) * c(3, 1) * p(3, 2);
  const double d_1 = c(2, 1) * c(3, 3) * p(2, 2) + c(2, 2) * c(3, 1) * p(2, 3) +
                     c(2, 3) * c(3, 2) * p(2, 1) - c(2, 1) * c(3, 2) * p(2, 3) -
                     c(2, 2) * c(3, 3) * p(2, 1) - c(2, 3) * c(3, 1) * p(2, 2);
  const PointCoefficients coefficients = point_coefficients(matrices);
  const auto expect_equal = [](double found, double printed) {
    EXPECT_NEAR(found / printed, 1, 1e-9);
  };
  expect_equal(coefficients.with_coordinate(0, 0), a_x1);
  expect_equal(coefficients.constant(2, 2), b_z3);
  expect_equal(coefficients.with_coordinate(3, 1), c_2);
  expect_equal(coefficients.constant(3, 0), d_1);
}

TEST(Triangulator, PointForm1HoldsAtAPixelWhoseRayIsParallelToTheFirstStripe) {
  // A camera and a projector with the same lens side by side: at column 0 the ray runs along y = 0.
  Scanner scanner;
  scanner.camera.intrinsic << 500, 0, 320, 0, 500, 240, 0, 0, 1;
  scanner.camera.size = {640, 480};
  scanner.projector = scanner.camera;
  scanner.translation = {-100, 0, 0};
  const ProjectionMatrices matrices = projection_matrices(scanner, Axis::x);
  const PointCoefficients coefficients = point_coefficients(matrices);
  const Eigen::Vector3d exact = triangulate(matrices, 0, 100, 0.4);
  EXPECT_LT(relative_difference(point_form1(coefficients, 0, 100)(0.4), exact), 1e-9);
  EXPECT_LT(relative_difference(point_form3(coefficients, 0, 100)(0.4), exact), 1e-9);
}

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
  static constexpr std::array names{"inverse", "form1", "form3"};
  return names[static_cast<std::size_t>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Method, TriangulatorBy,
                         testing::Values(PointMethod::inverse, PointMethod::form1,
                                         PointMethod::form3),
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
