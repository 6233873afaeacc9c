#include "slipstream/cloud/normals.h"

#include <algorithm>
#include <limits>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "slipstream/cloud/depth_step.h"
#include "slipstream/image/parallel_rows.h"

namespace slipstream {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

using Vector = Eigen::Vector3d;

/// The step along the surface from the neighbour before to the one after, of those that there are.
std::optional<Vector> surface_step(const Cloud& cloud, int column, int row, int right, int down,
                                   double largest_step) {
  const Vector centre = position_at(cloud, column, row);
  Vector step = Vector::Zero();
  int neighbours = 0;
  for (const int side : {-1, 1}) {
    const int c = column + side * right;
    const int r = row + side * down;
    if (c < 0 || r < 0 || c >= cloud.size().width || r >= cloud.size().height) continue;
    const Vector neighbour = position_at(cloud, c, r);
    if (!on_one_surface(centre, neighbour, largest_step)) continue;
    step += side * (neighbour - centre);
    ++neighbours;
  }
  return neighbours > 0 ? std::optional<Vector>(step) : std::nullopt;
}

using Tangents = Eigen::Matrix<double, 3, 2>;

std::optional<Tangents> tangents_to_neighbours(const Cloud& cloud, int column, int row,
                                               double largest_step) {
  const auto along_row = surface_step(cloud, column, row, 1, 0, largest_step);
  const auto along_column = surface_step(cloud, column, row, 0, 1, largest_step);
  if (!along_row || !along_column) return std::nullopt;
  Tangents tangents;
  tangents << *along_row, *along_column;
  return tangents;
}

/// How the points of the window change from column to column and from row to row, by least squares.
std::optional<Tangents> tangents_in_window(const Cloud& cloud, int column, int row, int reach,
                                           double largest_step) {
  const Vector centre = position_at(cloud, column, row);
  const Size size = cloud.size();
  Eigen::Matrix3d places = Eigen::Matrix3d::Zero(), points = Eigen::Matrix3d::Zero();
  for (int r = std::max(0, row - reach); r <= std::min(size.height - 1, row + reach); ++r) {
    for (int c = std::max(0, column - reach); c <= std::min(size.width - 1, column + reach); ++c) {
      const Vector point = position_at(cloud, c, r);
      if (!on_one_surface(centre, point, largest_step)) continue;
      const Vector place(c - column, r - row, 1);
      places += place * place.transpose();
      points += (point - centre) * place.transpose();
    }
  }
  // As large as that only where the pixels do not lie on a line.
  if (!(places.determinant() > 0.5)) return std::nullopt;
  return (points * places.inverse()).leftCols<2>();
}

template <class TangentsAt>
Normals normals_of(const Cloud& cloud, const TangentsAt& tangents_at) {
  const Size size = cloud.size();
  Normals normals{Image<float>(size, nan), Image<float>(size, nan), Image<float>(size, nan)};
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) {
      if (!(cloud.z(column, row) > 0)) continue;
      const std::optional<Tangents> tangents = tangents_at(column, row);
      if (!tangents) continue;
      Vector normal = tangents->col(0).cross(tangents->col(1)).normalized();
      if (normal.dot(position_at(cloud, column, row)) > 0) normal = -normal;
      normals.x(column, row) = static_cast<float>(normal.x());
      normals.y(column, row) = static_cast<float>(normal.y());
      normals.z(column, row) = static_cast<float>(normal.z());
    }
  });
  return normals;
}

}  // namespace

Normals surface_normals(const Cloud& cloud, double largest_step) {
  return normals_of(cloud, [&](int column, int row) {
    return tangents_to_neighbours(cloud, column, row, largest_step);
  });
}

Normals smoothed_normals(const Cloud& cloud, int reach, double largest_step) {
  return normals_of(cloud, [&](int column, int row) {
    return tangents_in_window(cloud, column, row, reach, largest_step);
  });
}

}  // namespace slipstream
