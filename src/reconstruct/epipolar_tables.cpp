#include "reconstruct/epipolar_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/LU>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "geometry/lens_residual.h"
#include "geometry/ray_table.h"
#include "geometry/stripe_geometry.h"

namespace slipstream {
namespace {

using Shift = EpipolarLines::Shift;
constexpr int terms = EpipolarLines::terms;
constexpr float least_y = EpipolarLines::least_y;

/// The polynomial depths are exact at every eighth pixel and linear in between.
constexpr int spacing = 8;

/// The same scanner with a camera that sees only the knots, up to one past the picture.
Scanner at_knots(Scanner scanner) {
  auto& [width, height] = scanner.camera.size;
  width = (width - 1) / spacing + 2;
  height = (height - 1) / spacing + 2;
  scanner.camera.intrinsic.topRows<2>() /= spacing;
  scanner.camera.residual = scaled(std::move(scanner.camera.residual), 1.0 / spacing);
  return scanner;
}

}  // namespace

EpipolarTables::EpipolarTables(const Scanner& camera, const Scanner& other, Axis axis)
    : scanner_(camera), axis_(axis) {
  lines_.rays = Image<EpipolarLines::Ray>(camera.camera.size);

  // 1. From the camera's frame to the other's, by way of the projector's.
  const Eigen::Matrix3d turn = other.rotation.transpose() * camera.rotation;
  turn_ = turn.cast<float>();
  lines_.translation =
      (other.rotation.transpose() * (camera.translation - other.translation)).cast<float>();

  // 2. The other camera's lens in float, without the sensor's tilt, which goes with its matrix.
  const auto& coefficients = other.camera.distortion.coefficients;
  std::transform(coefficients.begin(), coefficients.begin() + untilted_coefficient_count,
                 lines_.lens.begin(), [](double k) { return static_cast<float>(k); });
  lines_.straight = other.camera.distortion.is_zero();
  lines_.tilted = coefficients[12] != 0 || coefficients[13] != 0;
  lines_.sensor =
      (other.camera.intrinsic * sensor_tilt(coefficients[12], coefficients[13])).cast<float>();

  fill_shifts(other.camera);

  // 3. The rays, in the other camera's frame; solved for each pixel if the table cannot be made.
  const auto rays = ray_table(camera.camera);
  for_each_pixel(lines_.rays.size(), [&](int column, int row) {
    const Eigen::Vector3d ray =
        rays ? Eigen::Vector3d(rays->E_x(column, row), rays->E_y(column, row), 1)
             : ray_through(camera.camera, {column, row});
    const Eigen::Vector3f turned = (turn * ray).cast<float>();
    lines_.rays(column, row).turned = {turned.x(), turned.y(), turned.z()};
  });

  fill_depths(Triangulator(at_knots(camera), axis, PointMethod::form1));
}

/// Fits w by Chebyshev polynomials at the knots.
void EpipolarTables::fill_depths(const Triangulator& triangulate) {
  // 1. At the knots: w at the Chebyshev nodes, then coefficients, then powers of p.
  Image<std::array<float, terms>> depths(triangulate.scanner().camera.size);
  const Eigen::Matrix<double, terms, terms> to_powers =
      chebyshev_coefficients<terms>().transpose() * chebyshev_transform<terms>();

  for_each_pixel(depths.size(), [&](int column, int row) {
    Eigen::Matrix<double, terms, 1> values;
    for (int k = 0; k < terms; ++k) {
      const double p = std::cos(std::numbers::pi * (k + 0.5) / terms);
      values[k] = 1 / triangulate(column, row, 0.5 + p * (0.5 - least_y)).z();
    }
    const Eigen::Matrix<double, terms, 1> powers = to_powers * values;
    for (int k = 0; k < terms; ++k) depths(column, row)[k] = static_cast<float>(powers[k]);
  });

  // 2. Between the knots: bilinear interpolation of the coefficients.
  for_each_pixel(lines_.rays.size(), [&](int column, int row) {
    const int i = column / spacing, j = row / spacing;
    const float right = static_cast<float>(column % spacing) / spacing;
    const float down = static_cast<float>(row % spacing) / spacing;
    for (int k = 0; k < terms; ++k) {
      const float above = std::lerp(depths(i, j)[k], depths(i + 1, j)[k], right);
      const float below = std::lerp(depths(i, j + 1)[k], depths(i + 1, j + 1)[k], right);
      lines_.rays(column, row).depth[k] = std::lerp(above, below, down);
    }
  });
}

void EpipolarTables::fill_shifts(const Lens& other) {
  if (other.residual.terms.empty()) return;

  lines_.shifts = Image<Shift>(other.size);
  for_each_pixel(lines_.shifts.size(), [&](int column, int row) {
    const Eigen::Vector2d ideal(column, row);
    const Eigen::Vector2d shift = shifted_by(other.residual, ideal) - ideal;
    lines_.shifts(column, row) = {static_cast<float>(shift.x()), static_cast<float>(shift.y())};
  });
}

float EpipolarTables::inverse_depth(int column, int row, float y) const {
  const auto& depth = lines_.rays(column, row).depth;
  const float p = (y - 0.5F) / (0.5F - least_y);

  // Horner's scheme.
  float w = depth[terms - 1];
  for (int k = terms - 2; k >= 0; --k) w = w * p + depth[k];
  return w;
}

double EpipolarTables::coordinate_at(int column, int row, double w) const {
  // The point at depth 1 / w on the pixel's ray, back in the camera's frame.
  const Eigen::Vector3d ray = (turn_.transpose() * turned(column, row)).cast<double>();
  const Eigen::Vector3d point = in_projector_frame(scanner_, ray / ray.z() / w);
  if (!(point.z() > 0)) return nan;

  const Lens& projector = scanner_.projector;
  return coordinate_along(axis_, project(projector, point), projector.size);
}

Phasor near_phasor(const CameraPhases& camera, const Image<Phasor>& band,
                   const Eigen::Vector2f& at) {
  if (!(at.x() >= 0 && at.y() >= 0 && at.x() < static_cast<float>(band.width() - 1) &&
        at.y() < static_cast<float>(band.height() - 1))) {
    return 0;
  }

  const int left = static_cast<int>(at.x()), top = static_cast<int>(at.y());
  if (camera.surrounded(left, top) == 0) return 0;

  const float right = at.x() - static_cast<float>(left), down = at.y() - static_cast<float>(top);
  const Phasor *const above = band.row(top) + left, *const below = band.row(top + 1) + left;
  return (1 - down) * ((1 - right) * above[0] + right * above[1]) +
         down * ((1 - right) * below[0] + right * below[1]);
}

}  // namespace slipstream
