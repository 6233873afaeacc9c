#include "slipstream/cloud/surface.h"

#include <algorithm>
#include <cmath>

namespace slipstream {
namespace {

/// A triangle by the pixels of its corners, or by their places in a block:
///   0 1
///   2 3
using Triangle = std::array<std::uint32_t, 3>;
using Halves = std::array<Triangle, 2>;

constexpr Halves falling{{{0, 2, 3}, {0, 3, 1}}};
constexpr Halves rising{{{0, 2, 1}, {1, 2, 3}}};

struct Block {
  std::array<std::uint32_t, 4> pixels;
  std::array<Eigen::Vector3d, 4> points;
};

bool is_whole(const Block& block, const Triangle& corners, double largest_step) {
  const auto joined = [&](std::size_t i, std::size_t k) {
    return on_one_surface(block.points[corners[i]], block.points[corners[k]], largest_step);
  };
  return joined(0, 1) && joined(1, 2) && joined(2, 0);
}

void append_block(const Block& block, double largest_step, std::vector<Triangle>& triangles) {
  const auto step = [&](std::size_t i, std::size_t k) {
    return std::abs(block.points[i].z() - block.points[k].z());
  };
  const auto wholes = [&](const Halves& halves) {
    return std::count_if(halves.begin(), halves.end(),
                         [&](const Triangle& half) { return is_whole(block, half, largest_step); });
  };
  const auto by_falling = wholes(falling), by_rising = wholes(rising);
  const bool falls = by_falling == by_rising ? step(0, 3) <= step(1, 2) : by_falling > by_rising;
  for (const Triangle& half : falls ? falling : rising) {
    if (!is_whole(block, half, largest_step)) continue;
    triangles.push_back({block.pixels[half[0]], block.pixels[half[1]], block.pixels[half[2]]});
  }
}

/// By the indices of pixels, row by row.
std::vector<Triangle> triangles_of(const Cloud& cloud, double largest_step) {
  std::vector<Triangle> triangles;
  for_each_pixel_in_order(
      Size{cloud.size().width - 1, cloud.size().height - 1}, [&](int column, int row) {
        Block block;
        for (int i = 0; i < 4; ++i) {
          const int c = column + i % 2, r = row + i / 2;
          const auto place = static_cast<std::size_t>(i);
          block.pixels[place] = static_cast<std::uint32_t>(r * cloud.size().width + c);
          block.points[place] = position_at(cloud, c, r);
        }
        append_block(block, largest_step, triangles);
      });
  return triangles;
}

}  // namespace

Surface surface_of(const Cloud& cloud, double largest_step) {
  Surface surface{.triangles = triangles_of(cloud, largest_step),
                  .picture = Image<std::uint8_t>(cloud.size())};
  std::transform(cloud.intensity.begin(), cloud.intensity.end(), surface.picture.begin(),
                 grey_level);
  constexpr auto unused = static_cast<std::uint32_t>(-1);
  std::vector<std::uint32_t> vertex_of(cloud.z.pixel_count(), unused);
  const auto width = static_cast<std::uint32_t>(cloud.size().width);
  const Eigen::Vector2d size(cloud.size().width, cloud.size().height);
  for (Triangle& triangle : surface.triangles) {
    for (std::uint32_t& corner : triangle) {
      const std::uint32_t pixel = corner;
      corner = vertex_of[pixel];
      if (corner != unused) continue;
      corner = vertex_of[pixel] = static_cast<std::uint32_t>(surface.vertices.size());
      const auto column = static_cast<int>(pixel % width), row = static_cast<int>(pixel / width);
      surface.vertices.push_back(position_at(cloud, column, row).cast<float>());
      surface.intensity.push_back(cloud.intensity(column, row));
      const Eigen::Vector2d centre(column + 0.5, row + 0.5);
      surface.texture.emplace_back(centre.cwiseQuotient(size).cast<float>());
    }
  }
  return surface;
}

}  // namespace slipstream
