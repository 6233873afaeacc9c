#include "slipstream/cloud/normals.h"

#include <limits>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

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

}  // namespace

Normals surface_normals(const Cloud& cloud, double largest_step) {
  const Size size = cloud.size();
  Normals normals{Image<float>(size, nan), Image<float>(size, nan), Image<float>(size, nan)};
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) {
      const auto along_row = surface_step(cloud, column, row, 1, 0, largest_step);
      const auto along_column = surface_step(cloud, column, row, 0, 1, largest_step);
      if (!along_row || !along_column) continue;
      Vector normal = along_row->cross(*along_column).normalized();
      if (normal.dot(position_at(cloud, column, row)) > 0) normal = -normal;
      normals.x(column, row) = static_cast<float>(normal.x());
      normals.y(column, row) = static_cast<float>(normal.y());
      normals.z(column, row) = static_cast<float>(normal.z());
    }
  });
  return normals;
}

}  // namespace slipstream
