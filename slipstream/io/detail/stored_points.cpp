#include "slipstream/io/detail/stored_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string>

#include <tiny_obj_loader.h>

#include "slipstream/error/error.h"
#include "slipstream/io/number_reader.h"

namespace slipstream {
namespace {

struct ObjFile {
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
};

ObjFile loaded_obj(std::span<const std::uint8_t> bytes) {
  std::istringstream stream(std::string(bytes.begin(), bytes.end()));
  ObjFile file;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  constexpr bool triangulate = true, white_where_no_colour = false;
  if (!tinyobj::LoadObj(&file.attributes, &file.shapes, &materials, &warning, &error, &stream,
                        nullptr, triangulate, white_where_no_colour)) {
    throw Error("it is no OBJ");
  }
  return file;
}

}  // namespace

StoredPoints stl_points(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t header = 80, of_triangle = 50;
  NumberReader reader(bytes.subspan(std::min(header, bytes.size())));
  reader.set_format(NumberFormat::little_endian);
  const auto count = static_cast<std::size_t>(reader.number(NumberType::uint32));
  if (reader.left().size() != count * of_triangle) {
    throw Error("it is not as long as a binary STL of so many triangles");
  }
  std::vector<std::array<double, 3>> corners;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::array<double, 3>, 4> normal_and_corners;
    for (auto& vector : normal_and_corners) {
      for (double& number : vector) number = reader.number(NumberType::float32);
    }
    static_cast<void>(reader.number(NumberType::uint16));
    for (std::size_t k = 1; k < 4; ++k) {
      const auto& [x, y, z] = normal_and_corners[k];
      if (std::isfinite(x + y + z)) corners.push_back(normal_and_corners[k]);
    }
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  StoredPoints stored;
  for (const auto& [x, y, z] : corners) stored.points.push_back({.x = x, .y = y, .z = z});
  return stored;
}

StoredPoints obj_points(std::span<const std::uint8_t> bytes) {
  StoredPoints stored;
  const tinyobj::attrib_t attributes = loaded_obj(bytes).attributes;
  const auto& at = attributes.vertices;
  const bool coloured = attributes.colors.size() == at.size();
  for (std::size_t i = 0; i + 2 < at.size(); i += 3) {
    stored.points.push_back({.x = at[i],
                             .y = at[i + 1],
                             .z = at[i + 2],
                             .intensity = coloured ? 255 * attributes.colors[i + 1] : 0});
  }
  return stored;
}

Mesh obj_mesh(std::span<const std::uint8_t> bytes) {
  const auto [attributes, shapes] = loaded_obj(bytes);
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

}  // namespace slipstream
