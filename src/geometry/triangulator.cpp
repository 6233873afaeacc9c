#include "geometry/triangulator.h"

#include <cmath>
#include <type_traits>

#include <Eigen/LU>

#include "base/numbers.h"

namespace slipstream {
namespace {

using Row = Eigen::Matrix<double, 1, 4>;

/// The homogeneous point where three planes meet: signed 3x3 minors of their rows.
Eigen::Vector4d meet(const Row& p, const Row& q, const Row& r) {
  Eigen::Matrix<double, 3, 4> rows;
  rows << p, q, r;

  Eigen::Vector4d point;
  for (int left_out = 0; left_out < 4; ++left_out) {
    // The determinant without one column, with alternating sign.
    Eigen::Matrix3d minor;
    for (int column = 0, next = 0; column < 4; ++column) {
      if (column != left_out) minor.col(next++) = rows.col(column);
    }

    point(left_out) = (left_out % 2 == 0 ? 1 : -1) * minor.determinant();
  }

  return point;
}

/// meet(m_1 - x m_3, m_2 - y m_3, plane) for every pixel (x, y): the x y term vanishes.
PixelPolynomial meet_ray(const Eigen::Matrix<double, 3, 4>& m, const Row& plane) {
  PixelPolynomial polynomial;
  polynomial.col(0) = -meet(m.row(2), m.row(1), plane);
  polynomial.col(1) = -meet(m.row(0), m.row(2), plane);
  polynomial.col(2) = meet(m.row(0), m.row(1), plane);
  return polynomial;
}

}  // namespace

ProjectionMatrices projection_matrices(const Scanner& scanner, Axis axis) {
  Eigen::Matrix<double, 3, 4> camera = Eigen::Matrix<double, 3, 4>::Zero();
  camera.leftCols<3>() = scanner.camera.intrinsic;

  Eigen::Matrix<double, 3, 4> pose;
  pose << scanner.rotation, scanner.translation;
  const Eigen::Matrix<double, 3, 4> projector = scanner.projector.intrinsic * pose;
  const int length = length_along(axis, scanner.projector.size);
  return {camera, projector.row(axis == Axis::x ? 0 : 1) / length, projector.row(2)};
}

Eigen::Vector3d triangulate(const ProjectionMatrices& matrices, double x, double y, double y_p) {
  const auto& m = matrices.camera;
  Eigen::Matrix<double, 3, 4> equations;
  equations << m.row(0) - m.row(2) * x,  //
      m.row(1) - m.row(2) * y,           //
      matrices.projector_coordinate - matrices.projector_depth * y_p;

  const Eigen::Matrix3d left = equations.leftCols<3>();
  const Eigen::Vector3d right = -equations.col(3);
  return left.inverse() * right;  // (1.15)
}

PointCoefficients point_coefficients(const ProjectionMatrices& matrices) {
  return {.with_coordinate = -meet_ray(matrices.camera, matrices.projector_depth),
          .constant = meet_ray(matrices.camera, matrices.projector_coordinate),
          .camera = matrices.camera};
}

PointForm1 point_form1(const PointCoefficients& coefficients, double x, double y) {
  const Eigen::Vector3d pixel(x, y, 1);
  const Eigen::Vector4d a = coefficients.with_coordinate * pixel;
  const Eigen::Vector4d b = coefficients.constant * pixel;

  // Zero if the pixel's ray is parallel to the plane y^p = 0. Its points are still valid, so the
  // tables store the limit.
  const double D = 1 / (b.w() == 0 ? 1e-100 : b.w());

  return {a.x() * D, b.x() * D, a.y() * D, b.y() * D, a.z() * D, b.z() * D, a.w() * D};
}

PointForm3 point_form3(const PointCoefficients& coefficients, double x, double y) {
  const PointForm1 form = point_form1(coefficients, x, y);
  const double M_z = form.A_z / form.C;
  const auto& m = coefficients.camera;

  // Minors of M^c's columns p and q, as a function of the pixel; E and F are ratios of them.
  const auto minors = [&](int p, int q) {
    return (m(1, p) * m(2, q) - m(1, q) * m(2, p)) * x +
           (m(0, q) * m(2, p) - m(0, p) * m(2, q)) * y + (m(0, p) * m(1, q) - m(0, q) * m(1, p));
  };

  const double denominator = minors(0, 1);

  return {.M_z = M_z,
          .N_z = form.B_z - M_z,
          .C = form.C,
          .E_x = minors(1, 2) / denominator,
          .F_x = minors(1, 3) / denominator,
          .E_y = minors(2, 0) / denominator,
          .F_y = minors(3, 0) / denominator};
}

Eigen::Vector3d PointForm1::operator()(double y_p) const {
  const double T_1 = 1 / (C * y_p + 1);                                                // (2.21)
  return {(A_x * y_p + B_x) * T_1, (A_y * y_p + B_y) * T_1, (A_z * y_p + B_z) * T_1};  // -(2.24)
}

Eigen::Vector3d PointForm3::operator()(double y_p) const {
  const double Z = M_z + N_z / (C * y_p + 1);  // (2.29)
  return {E_x * Z + F_x, E_y * Z + F_y, Z};    // (2.30), (2.31)
}

Triangulator::Triangulator(const Scanner& scanner, Axis axis, PointMethod method)
    : scanner_(scanner), axis_(axis) {
  require_valid(scanner);
  require_depth_visible(scanner, axis);

  // The camera's lens goes into the table, and so does all that does not depend on the coordinate.
  matrices_ = projection_matrices(scanner, axis);
  const Image<PixelPosition> pixels = undistorted_pixels(scanner.camera);
  if (method == PointMethod::inverse) table_ = pixels;
  if (method == PointMethod::form1) table_ = point_table(pixels, matrices_, point_form1);
  if (method == PointMethod::form3) table_ = point_table(pixels, matrices_, point_form3);
}

Eigen::Vector3d Triangulator::operator()(int column, int row, double y) const {
  // Each method's table has entries of its own type.
  return std::visit(
      [&]<class Entry>(const Image<Entry>& table) {
        const Entry& entry = table(column, row);
        if constexpr (std::is_same_v<Entry, PixelPosition>) {
          return through_projector_lens(
              [&](double y_p) { return triangulate(matrices_, entry.x, entry.y, y_p); }, y);
        } else {
          return through_projector_lens(entry, y);
        }
      },
      table_);
}

/// Finds the undistorted coordinate whose point on the ray is lit at coordinate y: secant method on
/// the difference, which starts so close that four steps reach rounding.
template <class PointOf>
Eigen::Vector3d Triangulator::through_projector_lens(const PointOf& point_of, double y) const {
  if (is_straight(scanner_.projector)) return point_of(y);
  constexpr int most_iterations = 30;
  constexpr double tolerance = 1e-14;

  const auto error = [&](double undistorted) {
    const Eigen::Vector3d point = in_projector_frame(scanner_, point_of(undistorted));
    return coordinate_along(axis_, project(scanner_.projector, point), scanner_.projector.size) - y;
  };

  double before = y;
  double error_before = error(before);
  double now = y - error_before;
  for (int iteration = 0; iteration < most_iterations; ++iteration) {
    const double error_now = error(now);
    if (std::abs(error_now) <= tolerance) return point_of(now);

    const double slope = (error_now - error_before) / (now - before);
    before = now;
    error_before = error_now;
    now -= error_now / slope;
  }

  return Eigen::Vector3d::Constant(nan);
}

}  // namespace slipstream
