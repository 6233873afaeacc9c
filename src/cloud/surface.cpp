#include "slipstream/surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include <Eigen/Geometry>

#include "base/parallel_rows.h"

namespace slipstream {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

using Vector = Eigen::Vector3d;

/// The step along the surface between the available neighbours before and after.
std::optional<Vector> surface_step(const Cloud& cloud, int column, int row, int right, int down) {
  constexpr double largest_step = 8;  // see on_one_surface

  const Vector centre = position_at(cloud, column, row);
  Vector step = Vector::Zero();
  int neighbours = 0;

  for (const int side : {-1, 1}) {
    const int c = column + side * right;
    const int r = row + side * down;
    if (c < 0 || r < 0 || c >= cloud.size().width || r >= cloud.size().height) continue;

    const Vector neighbour = position_at(cloud, c, r);
    if (!on_one_surface(centre, neighbour, largest_step)) continue;
    step += side * (neighbour - centre);
    ++neighbours;
  }

  return neighbours > 0 ? std::optional<Vector>(step) : std::nullopt;
}

/// The sum over five pixels along the row or column; ignores NaN.
Image<float> summed(const Image<float>& image, int right, int down) {
  constexpr int reach = 2;

  Image<float> sums(image.size());
  for_each_row(image.height(), [&](int row) {
    for (int step = -reach; step <= reach; ++step) {
      const int from_row = row + step * down;
      if (from_row < 0 || from_row >= image.height()) continue;

      // Columns whose neighbour lies in the picture.
      const int first = std::max(0, -step * right);
      const int end = std::min(image.width(), image.width() - step * right);

      const float* const from = image.row(from_row);
      float* const to = sums.row(row);
      for (int column = first; column < end; ++column) {
        const float value = from[column + step * right];
        to[column] += std::isnan(value) ? 0.0F : value;
      }
    }
  });

  return sums;
}

/// A triangle by the pixels of its corners, or by their indices in a block:
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

/// Triangles of pixel indices, row by row.
std::vector<Triangle> triangles_of(const Cloud& cloud, double largest_step) {
  std::vector<Triangle> triangles;

  const auto [width, height] = cloud.size();
  for_each_pixel_in_order({width - 1, height - 1}, [&, width = width](int column, int row) {
    // The four points of the block.
    Block block;
    for (int i = 0; i < 4; ++i) {
      const int c = column + i % 2, r = row + i / 2;
      const auto place = static_cast<std::size_t>(i);
      block.pixels[place] = static_cast<std::uint32_t>(r) * static_cast<std::uint32_t>(width) +
                            static_cast<std::uint32_t>(c);
      block.points[place] = position_at(cloud, c, r);
    }

    // Divide it so that more triangles are whole; if equal, along the smaller step in depth.
    const auto step = [&](std::size_t i, std::size_t k) {
      return std::abs(block.points[i].z() - block.points[k].z());
    };
    const auto wholes = [&](const Halves& halves) {
      return std::ranges::count_if(
          halves, [&](const Triangle& half) { return is_whole(block, half, largest_step); });
    };
    const auto by_falling = wholes(falling), by_rising = wholes(rising);
    const bool falls = by_falling == by_rising ? step(0, 3) <= step(1, 2) : by_falling > by_rising;

    for (const Triangle& half : falls ? falling : rising) {
      if (!is_whole(block, half, largest_step)) continue;
      triangles.push_back({block.pixels[half[0]], block.pixels[half[1]], block.pixels[half[2]]});
    }
  });

  return triangles;
}

/// Unit normals summed over 5x5 pixels.
struct NormalSums {
  Normals normals;
  Image<float> count;  ///< how many were summed
};

NormalSums sums_of_normals(const Cloud& cloud) {
  NormalSums sums{.normals = surface_normals(cloud), .count = Image<float>(cloud.size())};
  auto& [normals, count] = sums;

  // Missing normals count as 0 in the sums.
  std::ranges::transform(normals.z, count.begin(),
                         [](float z) { return std::isnan(z) ? 0.0F : 1.0F; });

  // Along the rows, then along the columns.
  for (Image<float>* const part : {&normals.x, &normals.y, &normals.z, &count}) {
    *part = summed(summed(*part, 1, 0), 0, 1);
  }

  return sums;
}

constexpr float slope_unknown = 0.82F;

/// How far a slope is known, 0 to 1, from the length of the mean of unit normals: almost 1 where
/// they agree, 0.7 at an edge of a cube, and under a half if noise of depth exceeds the distance
/// between pixels.
float certainty_of_slope(float mean_length) {
  constexpr float unknown = 0.5F, certain = 0.9F;
  return std::clamp((mean_length - unknown) / (certain - unknown), 0.0F, 1.0F);
}

/// Shading of a list of points in the camera's frame: that of their picture by a camera that sees
/// about one point in each pixel.
Image<float> shading_of_list(const Cloud& list) {
  Image<float> brightness(list.size(), slope_unknown);

  // The rays of the points, and the field that they span.
  std::vector<std::pair<int, Eigen::Vector2d>> rays;  // of points before the camera: X / Z, Y / Z
  Eigen::AlignedBox2d field;

  for (int n = 0; n < list.size().width; ++n) {
    const Eigen::Vector2d ray = position_at(list, n, 0).hnormalized();
    if (!(list.z(n, 0) > 0) || !ray.allFinite()) continue;

    rays.emplace_back(n, ray);
    field.extend(ray);
  }

  // Size of the picture, with about one point in each pixel.
  if (rays.empty()) return brightness;
  const double pixel = std::sqrt(field.volume() / static_cast<double>(rays.size()));
  const Eigen::Vector2d size = field.sizes() / pixel;

  // A line of points determines no surface, and its picture would be larger than memory.
  if (!(size.x() >= 1 && size.y() >= 1)) return brightness;

  const auto for_each_point_seen = [&](const auto& visit) {
    for (const auto& [n, ray] : rays) {
      const Eigen::Vector2d place = (ray - field.min()) / pixel;
      visit(n, static_cast<int>(place.x()), static_cast<int>(place.y()));
    }
  };

  // Draw the points into the picture, shade it, and read the brightness back.
  Cloud picture({static_cast<int>(size.x()) + 1, static_cast<int>(size.y()) + 1});
  std::fill(picture.z.begin(), picture.z.end(), nan);
  for_each_point_seen([&](int n, int column, int row) {
    picture.x(column, row) = list.x(n, 0);
    picture.y(column, row) = list.y(n, 0);
    picture.z(column, row) = list.z(n, 0);
  });

  const Image<float> seen = shading(picture);
  for_each_point_seen([&](int n, int column, int row) { brightness(n, 0) = seen(column, row); });

  return brightness;
}

}  // namespace

Normals surface_normals(const Cloud& cloud) {
  require_camera_frame(cloud);
  const Size size = cloud.size();

  Normals normals{Image<float>(size, nan), Image<float>(size, nan), Image<float>(size, nan)};
  for_each_pixel(size, [&](int column, int row) {
    if (!(cloud.z(column, row) > 0)) return;

    const auto along_row = surface_step(cloud, column, row, 1, 0);
    const auto along_column = surface_step(cloud, column, row, 0, 1);
    if (!along_row || !along_column) return;

    Vector normal = along_row->cross(*along_column).normalized();
    if (normal.dot(position_at(cloud, column, row)) > 0) normal = -normal;

    normals.x(column, row) = static_cast<float>(normal.x());
    normals.y(column, row) = static_cast<float>(normal.y());
    normals.z(column, row) = static_cast<float>(normal.z());
  });

  return normals;
}

Normals smoothed_normals(const Cloud& cloud) {
  require_camera_frame(cloud);
  Normals normals = sums_of_normals(cloud).normals;

  for_each_pixel(cloud.size(), [&](int column, int row) {
    float &x = normals.x(column, row), &y = normals.y(column, row), &z = normals.z(column, row);

    // Length NaN makes the normal NaN.
    const bool known = cloud.z(column, row) > 0 && z != 0;
    const float length = known ? std::hypot(x, y, z) : nan;
    x /= length;
    y /= length;
    z /= length;
  });

  return normals;
}

Image<float> shading(const Cloud& cloud) {
  if (cloud.size().height == 1) return shading_of_list(cloud);

  const Eigen::Vector3f light = Eigen::Vector3f(-0.4F, -0.5F, -1.0F).normalized();
  const auto [normals, count] = sums_of_normals(cloud);

  Image<float> brightness(cloud.size(), slope_unknown);
  for_each_pixel(cloud.size(), [&](int column, int row) {
    if (!(cloud.z(column, row) > 0) || count(column, row) == 0) return;

    // Lambertian shading, with 0.3 of ambient light.
    const Eigen::Vector3f sum(normals.x(column, row), normals.y(column, row),
                              normals.z(column, row));
    const float length = std::max(sum.norm(), 1e-6F);
    const float lit = 0.3F + 0.7F * std::max(sum.dot(light) / length, 0.0F);

    const float certainty = certainty_of_slope(length / count(column, row));
    brightness(column, row) = slope_unknown + certainty * (lit - slope_unknown);
  });

  return brightness;
}

void move_to_frame(Normals& normals, const FramePose& pose) {
  const Eigen::Matrix3f turn = pose.transform.linear().cast<float>();

  for_each_pixel(normals.z.size(), [&](int column, int row) {
    const Eigen::Vector3f turned =
        turn *
        Eigen::Vector3f(normals.x(column, row), normals.y(column, row), normals.z(column, row));
    normals.x(column, row) = turned.x();
    normals.y(column, row) = turned.y();
    normals.z(column, row) = turned.z();
  });
}

void move_to_frame(Surface& surface, const FramePose& pose) {
  const std::string_view name = surface.frame ? std::string_view(surface.frame->to) : camera_frame;
  const Eigen::Isometry3d motion = pose_from_frame(pose, name).transform;

  for (Eigen::Vector3f& vertex : surface.vertices) {
    vertex = (motion * vertex.cast<double>()).cast<float>();
  }
  surface.frame = frame_after(surface.frame, pose);
}

Surface surface_of(const Cloud& cloud, double largest_step) {
  require_camera_frame(cloud);

  Surface surface{.triangles = triangles_of(cloud, largest_step),
                  .picture = Image<std::uint8_t>(cloud.size())};

  // The picture for the texture.
  std::transform(cloud.intensity.begin(), cloud.intensity.end(), surface.picture.begin(),
                 grey_level);

  // Replace pixels by the numbers of vertices: a pixel becomes one at its first use.
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
