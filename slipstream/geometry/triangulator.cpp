#include "slipstream/geometry/triangulator.h"

#include <cmath>
#include <limits>
#include <type_traits>

namespace slipstream {

Triangulator::Triangulator(const Scanner& scanner, Axis axis, PointMethod method)
    : scanner_(scanner), axis_(axis) {
  require_valid(scanner);
  require_depth_visible(scanner, axis);
  matrices_ = projection_matrices(scanner, axis);
  Image<PixelPosition> pixels = undistorted_pixels(scanner.camera);
  switch (method) {
    case PointMethod::inverse:
      table_ = std::move(pixels);
      break;
    case PointMethod::form1:
      table_ = point_table(pixels, matrices_, point_form1);
      break;
    case PointMethod::form2:
      table_ = point_table(pixels, matrices_, point_form2);
      break;
    case PointMethod::form3:
      table_ = point_table(pixels, matrices_, point_form3);
      break;
  }
}

Eigen::Vector3d Triangulator::operator()(int column, int row, double y) const {
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

/// Finds the undistorted coordinate whose point on the ray the projector lights at coordinate y:
/// the secant method on the difference, which starts so near that four steps reach rounding.
template <class PointOf>
Eigen::Vector3d Triangulator::through_projector_lens(const PointOf& point_of, double y) const {
  if (scanner_.projector.distortion.is_zero()) return point_of(y);
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
  return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace slipstream
