#include "slipstream/view/cloud_extent.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "slipstream/base/quantile.h"

namespace slipstream::view {
namespace {

/// Every so manyth pixel is looked at. Odd, so that all columns of a picture of even width are met.
std::size_t stride_over(std::size_t count) {
  constexpr std::size_t enough = 8192;
  return (count / enough) | 1U;
}

/// Organised: the median distance of a pixel's point to its neighbour's. A list of points: as if
/// they were spread over the largest side of their box.
float spacing_of(const PointImages& cloud, const Box& box) {
  const std::size_t count = cloud.z.pixel_count(), stride = stride_over(count);
  std::vector<float> distances;
  for (std::size_t i = 0; cloud.z.height() > 1 && i + 1 < count; i += stride) {
    const auto step = [i](const Image<float>& image) {
      return image.begin()[i + 1] - image.begin()[i];
    };
    const float distance = std::hypot(step(cloud.x), step(cloud.y), step(cloud.z));
    if (std::isfinite(distance) && distance > 0) distances.push_back(distance);
  }
  if (!distances.empty()) return quantile(distances, 0.5);
  const glm::vec3 sides = box.high - box.low;
  const float area = std::max({sides.x * sides.y, sides.y * sides.z, sides.x * sides.z});
  return std::sqrt(area / static_cast<float>(std::max<std::size_t>(count, 1)));
}

}  // namespace

Range robust_range(const Image<float>& values) {
  std::vector<float> finite = finite_values(values, stride_over(values.pixel_count()));
  if (finite.empty()) return {};
  return {quantile(finite, 0.01), quantile(finite, 0.99)};
}

CloudExtent extent_of(const PointImages& cloud) {
  const Range x = robust_range(cloud.x), y = robust_range(cloud.y), z = robust_range(cloud.z);
  CloudExtent extent{.box = {{x.low, y.low, z.low}, {x.high, y.high, z.high}}};
  extent.spacing = std::max(spacing_of(cloud, extent.box), 1e-6F);
  return extent;
}

float floor_height(const CloudExtent& extent) {
  return extent.box.high.y + 0.03F * extent.box.diagonal();
}

}  // namespace slipstream::view
