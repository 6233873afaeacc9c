#include "slipstream/cloud/detail/region.h"

#include <algorithm>
#include <cstddef>

namespace slipstream {
namespace {

bool is_between(double value, double a, double b) {
  return value >= std::min(a, b) && value <= std::max(a, b);
}

/// Even-odd: whether an odd number of sides lies to the right.
bool is_inside(const std::vector<PictureCorner>& polygon, int column, int row) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const PictureCorner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    if ((a.row > row) == (b.row > row)) continue;
    const double crossing = a.column + (row - a.row) / (b.row - a.row) * (b.column - a.column);
    if (crossing >= column) inside = !inside;
  }
  return inside;
}

}  // namespace

Image<std::uint8_t> outline_mask(const std::vector<PictureCorner>& outline, Size picture) {
  Image<std::uint8_t> mask(picture);
  for (int row = 0; row < picture.height; ++row) {
    for (int column = 0; column < picture.width; ++column) {
      const bool inside = outline.size() == 2
                              ? is_between(column, outline[0].column, outline[1].column) &&
                                    is_between(row, outline[0].row, outline[1].row)
                              : is_inside(outline, column, row);
      mask(column, row) = inside ? 1 : 0;
    }
  }
  return mask;
}

bool is_inside(const PointBox& box, const Cloud& cloud, int column, int row) {
  return is_between(cloud.x(column, row), box.least[0], box.largest[0]) &&
         is_between(cloud.y(column, row), box.least[1], box.largest[1]) &&
         is_between(cloud.z(column, row), box.least[2], box.largest[2]);
}

}  // namespace slipstream
