#include "slipstream/io/mesh_file.h"

#include <cstdint>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/ply_mesh.h"

namespace slipstream {
namespace {

Mesh obj_mesh(const std::vector<std::uint8_t>& bytes) {
  std::istringstream stream(std::string(bytes.begin(), bytes.end()));
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &stream)) return {};

  Mesh mesh;
  for (std::size_t i = 0; i + 2 < attributes.vertices.size(); i += 3) {
    mesh.vertices.emplace_back(attributes.vertices[i], attributes.vertices[i + 1],
                               attributes.vertices[i + 2]);
  }
  for (const tinyobj::shape_t& shape : shapes) {
    const auto& corners = shape.mesh.indices;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
      mesh.triangles.push_back(
          {corners[i].vertex_index, corners[i + 1].vertex_index, corners[i + 2].vertex_index});
    }
  }
  return mesh;
}

Mesh parsed(const std::filesystem::path& path, const std::string& extension) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  if (extension == ".obj") return obj_mesh(bytes);
  try {
    return ply_mesh(bytes);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}; a whole PLY mesh is wanted", path.string(), error.what()));
  }
}

}  // namespace

Mesh read_mesh(const std::filesystem::path& path) {
  const std::string extension = lower_case_extension(path);
  if (extension != ".ply" && extension != ".obj") {
    throw Error(fmt::format("{}: no mesh format has the ending '{}'; use .ply or .obj",
                            path.string(), extension));
  }
  Mesh mesh = parsed(path, extension);
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
