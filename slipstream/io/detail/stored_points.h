#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "slipstream/image/size.h"
#include "slipstream/simulate/mesh.h"

namespace slipstream {

struct StoredPoint {
  double x = 0, y = 0, z = 0, intensity = 0;
  double sigma_coordinate = 0, sigma_x = 0, sigma_y = 0, sigma_z = 0;
};

/// What a file says, before it is a cloud.
struct StoredPoints {
  std::vector<StoredPoint> points{};
  bool has_sigma = false;
  Size organised{};  ///< as so many columns and rows; 0: not
};

// Each throws Error, which does not name the file, for what is no such file or ends too soon.

/// The corners of the triangles of a binary STL file, each once, in no order.
StoredPoints stl_points(std::span<const std::uint8_t> bytes);

/// The vertices of an OBJ file; intensity is that of their colours.
StoredPoints obj_points(std::span<const std::uint8_t> bytes);

/// Its faces as triangles, all its parts as one mesh; their indices are not checked.
Mesh obj_mesh(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
