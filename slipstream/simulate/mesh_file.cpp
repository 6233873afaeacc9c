#include "slipstream/simulate/mesh_file.h"

#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/io/detail/stored_points.h"
#include "slipstream/io/file.h"

namespace slipstream {

Mesh read_mesh(const std::filesystem::path& path) {
  require_ending(path, "mesh format", {".ply", ".obj"});
  StoredPoints stored = read_points(path);
  Mesh mesh{.vertices = {}, .triangles = std::move(stored.triangles)};
  for (const auto& point : stored.points) mesh.vertices.emplace_back(point.x, point.y, point.z);
  if (mesh.triangles.empty()) {
    throw Error(fmt::format("{}: no triangle could be read; a whole PLY or OBJ mesh is wanted",
                            path.string()));
  }
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    if (!vertex.allFinite()) {
      throw Error(fmt::format("{}: a vertex is not finite", path.string()));
    }
  }
  for (const auto& triangle : mesh.triangles) {
    for (const int corner : triangle) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= mesh.vertices.size()) {
        throw Error(fmt::format("{}: a triangle names vertex {} of {}", path.string(), corner,
                                mesh.vertices.size()));
      }
    }
  }
  return mesh;
}

}  // namespace slipstream
