#include "cloud/depth_planes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "cloud/depth_rows.h"

namespace slipstream {
namespace {

// A surface ends where it is steeper than about 83 degrees, as in surface_normals. Second
// differences of independent noise have sqrt(6) times its standard deviation; 80 % are smaller than
// 1.28 of theirs.
constexpr float largest_slope = 8;       ///< step in depth, in distances between pixels
constexpr float largest_curvature = 1;   ///< change of this step, same unit
constexpr float common_share = 0.8F;     ///< of second differences, attributed to noise
constexpr float step_over_noise = 2.5F;  ///< 5.5 standard deviations of a difference of two
constexpr float bend_over_noise = 4;     ///< 5.1 standard deviations of a second difference

/// Calls `visit(column, row)` for pixels spread over the picture, except its left and right ends.
template <class Visit>
void for_each_sample(Size size, const Visit& visit) {
  constexpr int across = 24;
  const int step_x = std::max(1, size.width / across), step_y = std::max(1, size.height / across);

  for (int row = step_y / 2; row < size.height; row += step_y) {
    for (int column = 1 + step_x / 2; column + 1 < size.width; column += step_x) visit(column, row);
  }
}

float sampled_quantile(std::vector<float>& samples, double share) {
  constexpr std::size_t fewest = 8;
  return samples.size() < fewest ? std::numeric_limits<float>::infinity()
                                 : quantile(samples, share);
}

/// Distance to the next point in one direction, at most `widest`; 0 if there is none.
int distance_to_point(const Cloud& cloud, int column, int row, int right, int down, int widest) {
  const auto [width, height] = cloud.size();

  for (int i = 1; i <= widest; ++i) {
    const int c = column + i * right, r = row + i * down;
    if (c < 0 || r < 0 || c >= width || r >= height) break;
    if (cloud.z(c, r) > 0) return i;
  }

  return 0;
}

/// Adds the interpolation across a gap in one direction; `weight`: sum of the weights so far.
void add_across(const Cloud& cloud, int right, int down, int widest, const DepthLimits& limits,
                SurfaceMemory::Point& sum, float& weight) {
  // The points at both ends of the gap, if it is narrow enough.
  const int before = distance_to_point(cloud, sum.column, sum.row, -right, -down, widest);
  const int after = distance_to_point(cloud, sum.column, sum.row, right, down, widest);
  const int length = before + after;
  if (before == 0 || after == 0 || length - 1 > widest) return;

  // They must lie on one surface.
  const int c0 = sum.column - before * right, r0 = sum.row - before * down;
  const int c1 = sum.column + after * right, r1 = sum.row + after * down;
  const float z0 = cloud.z(c0, r0), z1 = cloud.z(c1, r1);
  if (!(std::abs(z1 - z0) <= limits.step * static_cast<float>(length) * z0)) return;
  // A plane's inverse depth is linear in the picture, and so is the ray.
  const float w = 1 / static_cast<float>(length);
  const float w0 = w * static_cast<float>(after) * w, w1 = w * static_cast<float>(before) * w;
  sum.x += w0 * cloud.x(c0, r0) / z0 + w1 * cloud.x(c1, r1) / z1;
  sum.y += w0 * cloud.y(c0, r0) / z0 + w1 * cloud.y(c1, r1) / z1;
  sum.z += w0 / z0 + w1 / z1;
  weight += w;
}

}  // namespace

void Components::find(Size picture, const DepthPlanes& planes, const BitPlane& kept) {
  // 1. Find the runs of linked pixels, row by row, and join those of neighbouring rows.
  runs_.clear();
  parent_.clear();

  std::size_t first_here = 0, ended = 0;
  for (int row = 0; row < picture.height; ++row) {
    std::size_t above = std::exchange(first_here, runs_.size()), here = first_here;

    const Word *const pixels = kept.row(row), *const pixels_above = kept.row(row - 1);

    Word linked_before = 0, same_before = 0;  // of the last pixel of the previous word
    for (int w = 0; w + 1 < BitPlane::stride_of(picture); ++w) {
      const auto next_of = [w](const Word* of) {
        return of[w] >> 1 | of[w + 1] << (word_pixels - 1);
      };

      // Links to the next pixel and from the row above.
      const Word linked = planes.to_right.row(row)[w] & pixels[w] & next_of(pixels);
      const Word joined = planes.to_below.row(row - 1)[w] & pixels_above[w] & pixels[w];

      // The next pixels link the same two runs.
      const Word same = joined & linked & planes.to_right.row(row - 1)[w] & next_of(pixels_above);

      // A run begins at a pixel without a link from the left, and ends at one without a link to the
      // right.
      for_each_bit(pixels[w] & ~(linked << 1 | linked_before), w, [&](int column) {
        parent_.push_back(static_cast<std::uint32_t>(runs_.size()));
        runs_.push_back({row, column, column});
      });
      for_each_bit(pixels[w] & ~linked, w, [&](int column) { runs_[ended++].last = column; });

      // The runs above and here that meet in this column get one root.
      for_each_bit(joined & ~(same << 1 | same_before), w, [&](int column) {
        while (runs_[above].last < column) ++above;
        while (here + 1 < runs_.size() && runs_[here + 1].first <= column) ++here;

        const std::uint32_t a = root(above), b = root(here);
        parent_[std::max(a, b)] = std::min(a, b);
      });

      linked_before = linked >> (word_pixels - 1);
      same_before = same >> (word_pixels - 1);
    }
  }

  // 2. Count the pixels of each component.
  pixels_.assign(runs_.size(), 0);
  for (std::size_t i = 0; i < runs_.size(); ++i) {
    parent_[i] = parent_[parent_[i]];  // the root, the first run of its component
    pixels_[parent_[i]] += static_cast<std::uint32_t>(runs_[i].last - runs_[i].first + 1);
  }
}

std::uint32_t Components::root(std::size_t run) {
  while (parent_[run] != run) run = parent_[run] = parent_[parent_[run]];
  return static_cast<std::uint32_t>(run);
}

DepthLimits depth_limits(const Cloud& cloud, std::vector<float>& samples) {
  // Distance between neighbouring rays, relative to the depth.
  samples.clear();
  for_each_sample(cloud.size(), [&](int column, int row) {
    const float z = cloud.z(column, row), next = cloud.z(column + 1, row);
    const float across = std::hypot(cloud.x(column + 1, row) / next - cloud.x(column, row) / z,
                                    cloud.y(column + 1, row) / next - cloud.y(column, row) / z);

    if (across > 0) samples.push_back(across);
  });

  const float distance = sampled_quantile(samples, 0.5);

  // Second differences in the row, relative to the depth: mostly noise.
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

std::size_t fill_gaps(Cloud& cloud, int widest, const DepthLimits& limits, SurfaceMemory& memory) {
  // Find all filled points before any is stored, so that none grows from another.
  memory.found.clear();
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    const Validity why = cloud.validity(column, row);
    if (why == Validity::outside_region || why == Validity::out_of_range) return;
    if (cloud.z(column, row) > 0) return;

    SurfaceMemory::Point sum{.column = column, .row = row};
    float weight = 0;
    add_across(cloud, 1, 0, widest, limits, sum, weight);
    add_across(cloud, 0, 1, widest, limits, sum, weight);
    if (weight == 0) return;

    const float z = weight / sum.z;
    memory.found.push_back({column, row, sum.x / weight * z, sum.y / weight * z, z});
  });

  for (const SurfaceMemory::Point& point : memory.found) {
    cloud.x(point.column, point.row) = point.x;
    cloud.y(point.column, point.row) = point.y;
    cloud.z(point.column, point.row) = point.z;
    cloud.validity(point.column, point.row) = Validity::valid;
  }

  return memory.found.size();
}

void smooth(Cloud& cloud, int reach, const DepthLimits& limits, SurfaceMemory& memory) {
  // Reads the depths as they were before.
  memory.z = cloud.z;
  const Image<float>& z = memory.z;

  const auto inverse_at = [&](int column, int row) {
    const bool inside = column >= 0 && row >= 0 && column < z.width() && row < z.height();
    return inside ? 1 / z(column, row) : std::numeric_limits<float>::quiet_NaN();
  };

  for_each_pixel(z.size(), [&](int column, int row) {
    const float here = 1 / z(column, row);
    if (!(here > 0)) return;

    float sum = here, count = 1;
    // Half of the window: each pixel represents the pair with the opposite one.
    for (int down = 0; down <= reach; ++down) {
      for (int right = down == 0 ? 1 : -reach; right <= reach; ++right) {
        const float a = inverse_at(column - right, row - down);
        const float b = inverse_at(column + right, row + down);

        if (!(std::abs(a - 2 * here + b) <= limits.bend * here)) continue;
        sum += a + b;
        count += 2;
      }
    }

    // The mean inverse depth, as a factor along the ray.
    const float ratio = here * count / sum;
    for (const auto part : {&Cloud::x, &Cloud::y, &Cloud::z}) (cloud.*part)(column, row) *= ratio;
  });
}

}  // namespace slipstream
