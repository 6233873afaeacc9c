#include "reconstruct/lens_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "base/linear_algebra.h"
#include "base/parallel_rows.h"

namespace slipstream {
namespace {

/// Zeros of the Chebyshev polynomial of that degree, in [-1, 1].
std::array<double, lens_terms> node_places() {
  std::array<double, lens_terms> places;
  for (int j = 0; j < lens_terms; ++j) {
    places[j] = -std::cos((2 * j + 1) * std::numbers::pi / (2 * lens_terms));
  }
  return places;
}

/// The coordinates that the ray meets within the depth range and the field: least and largest.
std::pair<double, double> coordinates_on(const Eigen::Vector3d& ray, DepthRange depths,
                                         const Scanner& scanner, Axis axis) {
  constexpr double shortest = 10, longest = 2e4;  // mm, of a range without ends
  constexpr double past_field = 0.02, narrowest = 2e-3;
  constexpr int samples = 32;

  const double nearest = std::max(depths.nearest, shortest);
  const double farthest = std::min(depths.farthest, longest);

  double least = 1 + past_field, most = -past_field;
  for (int i = 0; i <= samples; ++i) {
    // Evenly in the logarithm of the depth.
    const double depth = nearest * std::pow(farthest / nearest, 1.0 * i / samples);
    const Eigen::Vector3d point = in_projector_frame(scanner, depth * ray);
    const double y =
        coordinate_along(axis, project(scanner.projector, point), scanner.projector.size);

    if (!(point.z() > 0 && std::isfinite(y))) continue;
    const double held = std::clamp(y, -past_field, 1 + past_field);
    least = std::min(least, held);
    most = std::max(most, held);
  }

  return {least, std::max(most, least + narrowest)};
}

/// The polynomial of a pixel in u, c_0 to c_7, from the points that the reference finds at the
/// lens_terms; NaN where it finds none.
Eigen::Vector<double, lens_terms> lens_polynomial(const Triangulator& triangulate,
                                                  const ProjectionMatrices& matrices, int column,
                                                  int row, const LensSegment& segment) {
  // From values at the nodes to powers of u.
  using Square = Eigen::Matrix<double, lens_terms, lens_terms>;
  static const std::array<double, lens_terms> places = node_places();
  static const Square solve = [] {
    Square powers;
    for (int j = 0; j < lens_terms; ++j) {
      for (int k = 0; k < lens_terms; ++k) powers(j, k) = std::pow(places[j], k);
    }
    return Square(powers.inverse());
  }();

  Eigen::Vector<double, lens_terms> shift;
  for (int j = 0; j < lens_terms; ++j) {
    const double y = segment.middle + places[j] / segment.scale;

    // The reference finds the point with the lens; its linear projection gives the undistorted
    // coordinate.
    const Eigen::Vector4d point = triangulate(column, row, y).homogeneous();
    const double undistorted =
        matrices.projector_coordinate.dot(point) / matrices.projector_depth.dot(point);
    shift[j] = undistorted - y;
  }
  return solve * shift;
}

/// From its first, middle and last pixel.
LensSegment lens_segment(const Triangulator& triangulate, const ProjectionMatrices& matrices,
                         DepthRange depths, int first, int row) {
  const Scanner& scanner = triangulate.scanner();
  const int last = std::min(first + LensSegment::pixels, scanner.camera.size.width) - 1;
  const std::array columns{first, (first + last) / 2, last};

  // 1. The coordinates of all three.
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const int column : columns) {
    const Eigen::Vector3d ray = ray_through(scanner.camera, {column, row});
    const auto [from, to] = coordinates_on(ray, depths, scanner, triangulate.axis());
    least = std::min(least, from);
    most = std::max(most, to);
  }
  LensSegment segment{.middle = static_cast<float>((least + most) / 2),
                      .scale = static_cast<float>(2 / (most - least))};

  // 2. A parabola through the coefficients of all three; the last segment may have fewer pixels.
  Eigen::Matrix3d powers;
  Eigen::Matrix<double, 3, lens_terms> values;
  for (int i = 0; i < 3; ++i) {
    const double t = columns[i] - first;
    powers.row(i) << 1, t, t * t;
    values.row(i) = lens_polynomial(triangulate, matrices, columns[i], row, segment).transpose();
  }

  // The least-norm solution, for segments of one or two pixels.
  const Eigen::Matrix<double, 3, lens_terms> parabolas = least_squares(powers, values).X;
  for (int k = 0; k < lens_terms; ++k) {
    for (int power = 0; power < 3; ++power) {
      segment.c[k][power] = static_cast<float>(parabolas(power, k));
    }
  }
  return segment;
}

}  // namespace

Image<LensSegment> lens_table(const Triangulator& triangulate, const ProjectionMatrices& matrices,
                              DepthRange depths) {
  const auto [width, height] = triangulate.scanner().camera.size;
  Image<LensSegment> table({(width + LensSegment::pixels - 1) / LensSegment::pixels, height});
  for_each_pixel(table.size(), [&](int i, int row) {
    table(i, row) = lens_segment(triangulate, matrices, depths, i * LensSegment::pixels, row);
  });
  return table;
}

double largest_shift(const Lens& lens, Axis axis) {
  constexpr int steps = 32;
  double largest = 0;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; j <= steps; ++j) {
      const Eigen::Vector2d pixel(1.0 * lens.size.width * i / steps,
                                  1.0 * lens.size.height * j / steps);

      const Eigen::Vector3d straight = lens.intrinsic * ray_through(lens, pixel);
      const Eigen::Vector2d shift = straight.head<2>() - pixel;

      const double share = coordinate_along(axis, shift, lens.size);
      largest = std::max(largest, std::isfinite(share) ? std::abs(share)
                                                       : std::numeric_limits<double>::infinity());
    }
  }

  return largest;
}

}  // namespace slipstream
