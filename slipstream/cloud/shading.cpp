#include "slipstream/cloud/shading.h"

#include <algorithm>

#include <Eigen/Core>

#include "slipstream/base/parallel_rows.h"
#include "slipstream/cloud/normals.h"

namespace slipstream {
Image<float> shading(const Cloud& cloud) {
  constexpr float slope_unknown = 0.82F;
  const Eigen::Vector3f light = Eigen::Vector3f(-0.4F, -0.5F, -1.0F).normalized();
  const auto [x, y, z] = smoothed_normals(cloud);
  Image<float> brightness(cloud.size(), slope_unknown);
  for_each_row(cloud.size().height, [&](int row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      const Eigen::Vector3f normal(x(column, row), y(column, row), z(column, row));
      if (normal.hasNaN()) continue;
      brightness(column, row) = 0.3F + 0.7F * std::max(normal.dot(light), 0.0F);
    }
  });
  return brightness;
}

}  // namespace slipstream
