#include "slipstream/cloud/detail/cloud_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "slipstream/base/quantile.h"

namespace slipstream {
namespace {

// A surface is given up where it is steeper than about 83 degrees, as by surface_normals. Second
// differences of independent noise are sqrt(6) of its standard deviation; eight in ten are smaller
// than 1.28 of theirs.
constexpr float largest_slope = 8;      ///< distances between pixels in depth, from one to the next
constexpr float largest_curvature = 1;  ///< likewise, how much that may change
constexpr float common_share = 0.8F;    ///< of second differences, taken for the noise's
constexpr float step_over_noise = 2.5F;  ///< 5.5 standard deviations of a difference of two
constexpr float bend_over_noise = 4;     ///< 5.1 of a second difference

/// Calls `visit(column, row)` for places spread over the picture, none at its left or right end.
template <class Visit>
void for_each_sample(Size size, const Visit& visit) {
  constexpr int across = 24;
  const int step_x = std::max(1, size.width / across), step_y = std::max(1, size.height / across);
  for (int row = step_y / 2; row < size.height; row += step_y) {
    for (int column = 1 + step_x / 2; column + 1 < size.width; column += step_x) {
      visit(column, row);
    }
  }
}

float sampled_quantile(std::vector<float>& samples, double share) {
  constexpr std::size_t fewest = 8;
  return samples.size() < fewest ? std::numeric_limits<float>::infinity()
                                 : quantile(samples, share);
}

}  // namespace

DepthLimits depth_limits(const Cloud& cloud, std::vector<float>& samples) {
  samples.clear();
  for_each_sample(cloud.size(), [&](int column, int row) {
    const float z = cloud.z(column, row), next = cloud.z(column + 1, row);
    const float across = std::hypot(cloud.x(column + 1, row) / next - cloud.x(column, row) / z,
                                    cloud.y(column + 1, row) / next - cloud.y(column, row) / z);
    if (across > 0) samples.push_back(across);
  });
  const float distance = sampled_quantile(samples, 0.5);
  samples.clear();
  for_each_sample(cloud.size(), [&](int column, int row) {
    const float* z = cloud.z.row(row) + column;
    const float bend = std::abs(z[-1] - 2 * z[0] + z[1]) / z[0];
    if (bend >= 0) samples.push_back(bend);
  });
  const float noise = sampled_quantile(samples, common_share);
  return {.step = largest_slope * distance + step_over_noise * noise,
          .bend = largest_curvature * distance + bend_over_noise * noise};
}

}  // namespace slipstream
