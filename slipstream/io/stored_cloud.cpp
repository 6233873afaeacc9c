#include "slipstream/io/stored_cloud.h"

#include <cmath>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/detail/stored_points.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

bool is_finite(const StoredPoint& point) {
  return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z);
}

StoredCloud cloud_of(StoredPoints stored) {
  const bool organised = stored.organised != Size{};
  if (!organised) {
    std::erase_if(stored.points, [](const StoredPoint& point) { return !is_finite(point); });
  }
  const Size size = organised ? stored.organised : Size{static_cast<int>(stored.points.size()), 1};
  StoredCloud result{.cloud = Cloud(size), .uncertainty = {}, .organised = organised};
  if (stored.has_sigma) result.uncertainty.emplace(size);
  for (std::size_t i = 0; i < stored.points.size(); ++i) {
    const StoredPoint& point = stored.points[i];
    const auto put = [i](Image<float>& image, double value) {
      image.begin()[i] = static_cast<float>(value);
    };
    put(result.cloud.intensity, point.intensity);
    if (!is_finite(point)) continue;
    put(result.cloud.x, point.x);
    put(result.cloud.y, point.y);
    put(result.cloud.z, point.z);
    result.cloud.validity.begin()[i] = Validity::valid;
    if (!result.uncertainty) continue;
    put(result.uncertainty->coordinate, point.sigma_coordinate);
    put(result.uncertainty->x, point.sigma_x);
    put(result.uncertainty->y, point.sigma_y);
    put(result.uncertainty->z, point.sigma_z);
  }
  return result;
}

}  // namespace

bool is_cloud_file(const fs::path& path) {
  return holds_points(path);
}

StoredCloud read_cloud(const fs::path& path) {
  StoredCloud stored = cloud_of(read_points(path));
  if (point_count(stored.cloud) == 0) throw Error(fmt::format("{}: no point in it", path.string()));
  return stored;
}

}  // namespace slipstream
