#include "slipstream/io/ply_mesh.h"

#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/ply_elements.h"

namespace slipstream {
namespace {

int index_from(double number) {
  const bool index = number >= 0 && number <= std::numeric_limits<int>::max();
  if (!index || number != std::floor(number)) {
    throw Error(fmt::format("{} is no index of a vertex", number));
  }
  return static_cast<int>(number);
}

void read_vertex(const ply::Element& element, NumberReader& reader, Mesh& mesh) {
  Eigen::Vector3d vertex = Eigen::Vector3d::Zero();
  for (const ply::Property& property : element.properties) {
    const std::vector<double> numbers = ply::read_property(property, reader);
    if (numbers.size() != 1 || property.name.size() != 1) continue;
    const char axis = property.name[0];
    if (axis >= 'x' && axis <= 'z') vertex(axis - 'x') = numbers[0];
  }
  mesh.vertices.push_back(vertex);
}

void read_face(const ply::Element& element, NumberReader& reader, Mesh& mesh) {
  for (const ply::Property& property : element.properties) {
    const std::vector<double> corners = ply::read_property(property, reader);
    if (property.name != "vertex_indices" && property.name != "vertex_index") continue;
    for (std::size_t i = 2; i < corners.size(); ++i) {
      mesh.triangles.push_back(
          {index_from(corners[0]), index_from(corners[i - 1]), index_from(corners[i])});
    }
  }
}

}  // namespace

Mesh ply_mesh(std::span<const std::uint8_t> bytes) {
  NumberReader reader(bytes);
  Mesh mesh;
  for (const ply::Element& element : ply::read_header(reader)) {
    if (element.properties.empty()) continue;
    for (std::size_t i = 0; i < element.count; ++i) {
      if (element.name == "vertex") {
        read_vertex(element, reader, mesh);
      } else {
        read_face(element, reader, mesh);
      }
    }
  }
  return mesh;
}

}  // namespace slipstream
