#include "slipstream/cloud/shading.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

#include "slipstream/cloud/normals.h"
#include "slipstream/image/parallel_rows.h"

namespace slipstream {
namespace {

constexpr int reach = 2;

/// The sum of a pixel and its neighbours to either side, along the row or along the column; what is
/// NaN counts for nothing.
Image<float> summed(const Image<float>& image, int right, int down) {
  Image<float> sums(image.size());
  for_each_row(image.height(), [&](int row) {
    for (int step = -reach; step <= reach; ++step) {
      const int from_row = row + step * down;
      if (from_row < 0 || from_row >= image.height()) continue;
      const int first = std::max(0, -step * right);
      const int end = std::min(image.width(), image.width() - step * right);
      const float* const from = image.row(from_row);
      float* const to = sums.row(row);
      for (int column = first; column < end; ++column) {
        const float value = from[column + step * right];
        to[column] += std::isnan(value) ? 0.0F : value;
      }
    }
  });
  return sums;
}

Image<float> smoothed(const Image<float>& image) {
  return summed(summed(image, 1, 0), 0, 1);
}

}  // namespace

Image<float> shading(const Cloud& cloud) {
  constexpr float slope_unknown = 0.82F;
  const Eigen::Vector3f light = Eigen::Vector3f(-0.4F, -0.5F, -1.0F).normalized();
  const Normals normals = surface_normals(cloud);
  const Image<float> x = smoothed(normals.x), y = smoothed(normals.y), z = smoothed(normals.z);
  Image<float> brightness(cloud.size(), slope_unknown);
  for_each_row(cloud.size().height, [&](int row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      const Eigen::Vector3f normal(x(column, row), y(column, row), z(column, row));
      if (normal.isZero(0)) continue;
      brightness(column, row) = 0.3F + 0.7F * std::max(normal.normalized().dot(light), 0.0F);
    }
  });
  return brightness;
}

}  // namespace slipstream
