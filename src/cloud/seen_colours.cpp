#include "cloud/seen_colours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/parallel_rows.h"

namespace slipstream {
namespace {

/// A point in the other camera: its pixel and its depth there, mm.
struct SeenPlace {
  float x, y, depth;
};

/// Where the other camera sees the points; NaN for invalid pixels and for points behind it. `pose`:
/// from the cloud's frame to that camera's.
Image<SeenPlace> places_in(const Cloud& cloud, const Lens& lens, const Eigen::Isometry3d& pose) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Image<SeenPlace> places(cloud.size(), SeenPlace{nan, nan, nan});

  for_each_pixel(cloud.size(), [&](int column, int row) {
    const Eigen::Vector3d point =
        pose * Eigen::Vector3f(cloud.x(column, row), cloud.y(column, row), cloud.z(column, row))
                   .cast<double>();
    if (!(point.z() > 0)) return;

    const Eigen::Vector2f pixel = project(lens, point).cast<float>();
    places(column, row) = {pixel.x(), pixel.y(), static_cast<float>(point.z())};
  });

  return places;
}

/// Depth of the nearest surface in each pixel of the other camera, mm. Four neighbours cover the
/// rectangle around their images, with the depth of the farthest, so that no surface hides itself.
Image<float> nearest_depths(const Image<SeenPlace>& places, Size size) {
  constexpr float widest = 24;  // pixels; beyond, they are on two surfaces, or beside the lens
  Image<float> nearest(size, std::numeric_limits<float>::infinity());

  for_each_pixel_in_order({places.width() - 1, places.height() - 1}, [&](int column, int row) {
    // 1. The rectangle of the four.
    const std::array corners{places(column, row), places(column + 1, row), places(column, row + 1),
                             places(column + 1, row + 1)};
    const bool whole = std::ranges::none_of(corners, [](const SeenPlace& corner) {
      return std::isnan(corner.x + corner.y + corner.depth);
    });
    const auto [left, right] = std::ranges::minmax(corners, {}, &SeenPlace::x);
    const auto [top, bottom] = std::ranges::minmax(corners, {}, &SeenPlace::y);
    if (!whole || right.x - left.x > widest || bottom.y - top.y > widest) return;

    const bool inside = right.x >= 0 && bottom.y >= 0 && left.x < static_cast<float>(size.width) &&
                        top.y < static_cast<float>(size.height);
    if (!inside) return;

    // 2. Its pixels.
    const float depth = std::ranges::max(corners, {}, &SeenPlace::depth).depth;
    const int last_column = std::min(size.width - 1, static_cast<int>(std::lround(right.x)));
    const int last_row = std::min(size.height - 1, static_cast<int>(std::lround(bottom.y)));
    for (int y = std::max(0, static_cast<int>(std::lround(top.y))); y <= last_row; ++y) {
      for (int x = std::max(0, static_cast<int>(std::lround(left.x))); x <= last_column; ++x) {
        nearest(x, y) = std::min(nearest(x, y), depth);
      }
    }
  });
  return nearest;
}

}  // namespace

Image<Colour> colours_seen_by(const Cloud& cloud, const Image<Colour>& picture, const Lens& lens,
                              const Eigen::Isometry3d& pose) {
  constexpr float behind = 1.01F;  // ratio of depths; less is roughness of one surface
  const Image<SeenPlace> places = places_in(cloud, lens, pose);
  const Image<float> nearest = nearest_depths(places, picture.size());

  Image<Colour> colours(cloud.size());
  for_each_pixel(cloud.size(), [&](int column, int row) {
    const SeenPlace& place = places(column, row);
    const float x = std::round(place.x), y = std::round(place.y);
    const bool inside = x >= 0 && y >= 0 && x < static_cast<float>(picture.width()) &&
                        y < static_cast<float>(picture.height());
    if (!inside) return;

    const int there = static_cast<int>(x), below = static_cast<int>(y);
    if (place.depth <= behind * nearest(there, below)) {
      colours(column, row) = picture(there, below);
    }
  });
  return colours;
}

}  // namespace slipstream
