#pragma once

#include <cstring>
#include <functional>
#include <utility>
#include <vector>

#include "slipstream/cloud/cloud.h"

namespace slipstream {

/// A cloud as a camera sees it whose pixels are 1 mm apart at a depth of 1 m. `depth`: of column
/// and row, mm; NaN for no point.
inline Cloud cloud_of_depths(Size size, const std::function<double(int, int)>& depth) {
  Cloud cloud(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double z = depth(column, row);
      if (!(z > 0)) continue;
      cloud.x(column, row) = static_cast<float>(1e-3 * (column - size.width / 2) * z);
      cloud.y(column, row) = static_cast<float>(1e-3 * (row - size.height / 2) * z);
      cloud.z(column, row) = static_cast<float>(z);
      cloud.validity(column, row) = Validity::valid;
    }
  }
  return cloud;
}

inline bool same_points(const Cloud& a, const Cloud& b) {
  const auto same = [](const auto& p, const auto& q) {
    return p.size() == q.size() &&
           std::memcmp(p.begin(), q.begin(), p.pixel_count() * sizeof(*p.begin())) == 0;
  };
  return same(a.x, b.x) && same(a.y, b.y) && same(a.z, b.z) && same(a.validity, b.validity);
}

/// Pixels of each point's component: points beside each other in a row or a column are connected
/// where `linked(z, other z)`. 0 where there is none. By a plain flood.
inline Image<int> component_sizes(const Cloud& cloud,
                                  const std::function<bool(float, float)>& linked) {
  const Size size = cloud.size();
  Image<int> sizes(size);
  for (int start = 0; start < size.width * size.height; ++start) {
    if (sizes.begin()[start] != 0 || !(cloud.z.begin()[start] > 0)) continue;
    std::vector<int> found{start};
    sizes.begin()[start] = -1;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const int column = found[i] % size.width, row = found[i] / size.width;
      for (const auto& [c, r] : {std::pair{column - 1, row}, std::pair{column + 1, row},
                                 std::pair{column, row - 1}, std::pair{column, row + 1}}) {
        if (c < 0 || r < 0 || c >= size.width || r >= size.height || sizes(c, r) != 0) continue;
        if (!(cloud.z(c, r) > 0) || !linked(cloud.z(column, row), cloud.z(c, r))) continue;
        sizes(c, r) = -1;
        found.push_back(r * size.width + c);
      }
    }
    for (const int pixel : found) sizes.begin()[pixel] = static_cast<int>(found.size());
  }
  return sizes;
}

}  // namespace slipstream
