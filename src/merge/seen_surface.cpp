#include "merge/seen_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/statistics.h"

namespace slipstream {

SeenSurface::SeenSurface(const View& view) {
  constexpr float pixel_spacings = 1.5F;
  constexpr int most_pixels = 4000;  // along a side
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();

  if (!view.from_origin || view.size() == 0) return;

  // 1. A picture that looks along the mean direction of the points.
  Eigen::Vector3f axis = Eigen::Vector3f::Zero();
  std::vector<float> ranges;
  for (const Eigen::Vector3f& point : view.points) {
    axis += point.normalized();
    ranges.push_back(point.norm());
  }
  axis.normalize();
  const Eigen::Vector3f right = axis.unitOrthogonal();
  to_picture_ << right.transpose(), axis.cross(right).transpose(), axis.transpose();

  Eigen::Vector2f low = Eigen::Vector2f::Constant(1e9F), high = -low;
  for (const Eigen::Vector3f& point : view.points) {
    const Eigen::Vector2f at = (to_picture_ * point).hnormalized();
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }

  pixel_ = std::max(pixel_spacings * view.spacing / quantile(ranges, 0.5),
                    (high - low).maxCoeff() / most_pixels);
  corner_ = low;
  const Eigen::Vector2i size = ((high - low) / pixel_).cast<int>() + Eigen::Vector2i::Ones();
  nearest_ = farthest_ = Image<float>({size.x(), size.y()}, nan);

  // 2. The range of distances in each pixel; comparisons with NaN are false.
  for (const Eigen::Vector3f& point : view.points) {
    int column = 0, row = 0;
    if (!pixel_of(point, column, row)) continue;
    const float range = point.norm();
    float& least = nearest_(column, row);
    float& most = farthest_(column, row);
    if (!(least < range)) least = range;
    if (!(most > range)) most = range;
  }
}

bool SeenSurface::pixel_of(const Eigen::Vector3f& place, int& column, int& row) const {
  const Eigen::Vector3f turned = to_picture_ * place;
  if (!(turned.z() > 0)) return false;
  const Eigen::Vector2f at = (turned.hnormalized() - corner_) / pixel_;
  if (!(at.cwiseAbs().maxCoeff() < 1e6F)) return false;
  column = static_cast<int>(std::floor(at.x()));
  row = static_cast<int>(std::floor(at.y()));
  return true;
}

Sight SeenSurface::at(const Eigen::Vector3f& place, float margin) const {
  constexpr int least_filled = 6;  // of the nine pixels around

  int column = 0, row = 0;
  if (nearest_.pixel_count() == 0 || !pixel_of(place, column, row)) return Sight::unknown;
  const auto [width, height] = nearest_.size();
  if (column < 1 || row < 1 || column >= width - 1 || row >= height - 1) return Sight::unknown;

  // The distances seen in and around the pixel.
  int filled = 0;
  float least = std::numeric_limits<float>::infinity(), most = 0;
  for (int y = row - 1; y <= row + 1; ++y) {
    for (int x = column - 1; x <= column + 1; ++x) {
      if (std::isnan(nearest_(x, y))) continue;
      ++filled;
      least = std::min(least, nearest_(x, y));
      most = std::max(most, farthest_(x, y));
    }
  }
  if (filled < least_filled) return Sight::unknown;

  const float range = place.norm();
  if (range < least - margin) return Sight::clear;
  return range > most + margin ? Sight::hidden : Sight::near;
}

}  // namespace slipstream
