#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "slipstream/base/size.h"

namespace slipstream {

struct StoredPoint {
  double x = 0, y = 0, z = 0, intensity = 0;
  double sigma_coordinate = 0, sigma_x = 0, sigma_y = 0, sigma_z = 0;
};

/// What a file says, before it is a cloud or a mesh.
struct StoredPoints {
  std::vector<StoredPoint> points{};
  /// Faces of .ply and .obj, as fans, by their corners' indices; these are not checked.
  std::vector<std::array<int, 3>> triangles{};
  bool has_sigma = false;
  Size organised{};  ///< as so many columns and rows; 0: not
};

/// Whether the file's ending is one that read_points knows.
bool holds_points(const std::filesystem::path& path);

/// See read_cloud. Throws Error, naming the file, where it is another file or ends too soon.
StoredPoints read_points(const std::filesystem::path& path);

}  // namespace slipstream
