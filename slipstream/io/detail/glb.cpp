#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <vector>

#include <nlohmann/json.hpp>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/io/detail/point_formats.h"
#include "slipstream/io/image_file.h"

namespace slipstream {
namespace {

using nlohmann::json;

// The numbers that glTF 2.0 gives its names.
constexpr std::uint32_t glb_magic = 0x46546C67, version = 2;
constexpr std::uint32_t json_chunk = 0x4E4F534A, binary_chunk = 0x004E4942;
constexpr int float32 = 5126, uint32 = 5125;
constexpr int vertex_buffer = 34962, index_buffer = 34963;
constexpr int linear = 9729, clamped = 33071;

/// From mm, y down and z forward, to metres, y up and z towards the camera; and back.
Eigen::Vector3f to_gltf(const Eigen::Vector3f& point) {
  return Eigen::Vector3f(point.x(), -point.y(), -point.z()) / 1000;
}
StoredPoint from_gltf(const std::array<float, 3>& point, double intensity) {
  return {.x = 1000.0 * point[0],
          .y = -1000.0 * point[1],
          .z = -1000.0 * point[2],
          .intensity = intensity};
}

/// The binary part of the file, and what the views in it are.
struct Binary {
  std::string bytes;
  json views = json::array();

  /// Returns the number of the view.
  std::size_t append(const void* data, std::size_t size, int target = 0) {
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
    if (target != 0) views.back()["target"] = target;
    bytes.append(static_cast<const char*>(data), size);
    bytes.resize((bytes.size() + 3) / 4 * 4);
    return views.size() - 1;
  }

  template <class Element>
  json accessor(const std::vector<Element>& elements, const char* type, int component, int target) {
    return {{"bufferView", append(elements.data(), sizeof(Element) * elements.size(), target)},
            {"componentType", component},
            {"count", elements.size() * (target == index_buffer ? 3 : 1)},
            {"type", type}};
  }
};

json positions_of(const Surface& surface, Binary& binary) {
  std::vector<Eigen::Vector3f> positions(surface.vertices.size());
  std::transform(surface.vertices.begin(), surface.vertices.end(), positions.begin(), to_gltf);
  constexpr float infinity = std::numeric_limits<float>::infinity();
  Eigen::Array3f least = Eigen::Array3f::Constant(infinity), most = -least;
  for (const Eigen::Vector3f& position : positions) {
    least = least.min(position.array());
    most = most.max(position.array());
  }
  json accessor = binary.accessor(positions, "VEC3", float32, vertex_buffer);
  accessor["min"] = {least.x(), least.y(), least.z()};
  accessor["max"] = {most.x(), most.y(), most.z()};
  return accessor;
}

json document_of(const Surface& surface, Binary& binary) {
  const json accessors{
      positions_of(surface, binary),
      binary.accessor(surface.texture, "VEC2", float32, vertex_buffer),
      binary.accessor(surface.intensity, "SCALAR", float32, vertex_buffer),
      binary.accessor(surface.triangles, "SCALAR", uint32, index_buffer),
  };
  const std::vector<std::uint8_t> picture = png_file(surface.picture);
  const std::size_t picture_view = binary.append(picture.data(), picture.size());
  return {
      {"asset", {{"version", "2.0"}, {"generator", "slipstream"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", {{{"mesh", 0}}}},
      {"meshes",
       {{{"primitives",
          {{{"attributes", {{"POSITION", 0}, {"TEXCOORD_0", 1}, {"_INTENSITY", 2}}},
            {"indices", 3},
            {"material", 0}}}}}}},
      {"materials",
       {{{"doubleSided", true},
         {"pbrMetallicRoughness",
          {{"baseColorTexture", {{"index", 0}}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}}}}},
      {"textures", {{{"source", 0}, {"sampler", 0}}}},
      {"samplers",
       {{{"magFilter", linear}, {"minFilter", linear}, {"wrapS", clamped}, {"wrapT", clamped}}}},
      {"images", {{{"bufferView", picture_view}, {"mimeType", "image/png"}}}},
      {"accessors", accessors},
      {"bufferViews", binary.views},
      {"buffers", {{{"byteLength", binary.bytes.size()}}}},
  };
}

/// The bytes from `offset`, `size` of them. Throws Error where they are not there.
std::span<const std::uint8_t> part(std::span<const std::uint8_t> bytes, std::size_t offset,
                                   std::size_t size) {
  if (offset > bytes.size() || size > bytes.size() - offset) throw Error("it is truncated");
  return bytes.subspan(offset, size);
}

std::uint32_t count_at(std::span<const std::uint8_t> bytes, std::size_t offset) {
  return number_at<std::uint32_t>(part(bytes, offset, sizeof(std::uint32_t)), 0);
}

std::size_t count_of(const json& number) {
  if (!number.is_number_unsigned()) throw Error("a count in it is no number");
  return number.get<std::size_t>();
}

/// The chunk that begins at `offset`, of that kind.
std::span<const std::uint8_t> chunk(std::span<const std::uint8_t> bytes, std::size_t offset,
                                    std::uint32_t kind) {
  if (count_at(bytes, offset + 4) != kind) throw Error("a chunk in it is of another kind");
  return part(bytes, offset + 8, count_at(bytes, offset));
}

/// The numbers of an accessor, `components` for each of its elements.
template <std::size_t components>
std::vector<std::array<float, components>> numbers_of(const json& document, const json& accessor_at,
                                                      std::span<const std::uint8_t> binary) {
  const json& accessor = document.at("accessors").at(count_of(accessor_at));
  const json& view = document.at("bufferViews").at(count_of(accessor.at("bufferView")));
  if (accessor.at("componentType") != float32 || view.contains("byteStride")) {
    throw Error("its vertices are not of 32-bit float, one behind the other");
  }
  std::vector<std::array<float, components>> numbers;
  const std::size_t count = count_of(accessor.at("count"));
  if (count > binary.size() / sizeof(numbers[0])) throw Error("it is truncated");
  numbers.resize(count);
  const auto offset_in = [](const json& of) {
    return of.contains("byteOffset") ? count_of(of["byteOffset"]) : 0;
  };
  const auto of_view = part(binary, offset_in(view), count_of(view.at("byteLength")));
  const auto bytes = part(of_view, offset_in(accessor), count * sizeof(numbers[0]));
  if (count > 0) std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

StoredPoints points_in(const json& document, std::span<const std::uint8_t> binary) {
  StoredPoints stored;
  for (const json& mesh : document.at("meshes")) {
    for (const json& primitive : mesh.at("primitives")) {
      const json& attributes = primitive.at("attributes");
      const auto positions = numbers_of<3>(document, attributes.at("POSITION"), binary);
      std::vector<std::array<float, 1>> intensity;
      if (attributes.contains("_INTENSITY")) {
        intensity = numbers_of<1>(document, attributes["_INTENSITY"], binary);
      }
      intensity.resize(positions.size());
      for (std::size_t i = 0; i < positions.size(); ++i) {
        stored.points.push_back(from_gltf(positions[i], intensity[i][0]));
      }
    }
  }
  return stored;
}

}  // namespace

std::string glb_file(const Surface& surface) {
  Binary binary;
  std::string text = document_of(surface, binary).dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  constexpr std::size_t header = 12, chunk_header = 8;
  std::string file;
  const auto size_of = [](std::size_t bytes) { return static_cast<std::uint32_t>(bytes); };
  append_numbers(file, glb_magic, version,
                 size_of(header + 2 * chunk_header + text.size() + binary.bytes.size()),
                 size_of(text.size()), json_chunk);
  file += text;
  append_numbers(file, size_of(binary.bytes.size()), binary_chunk);
  return file + binary.bytes;
}

StoredPoints glb_points(std::span<const std::uint8_t> bytes) {
  if (count_at(bytes, 0) != glb_magic || count_at(bytes, 4) != version) {
    throw Error("it is no binary glTF 2.0");
  }
  constexpr std::size_t header = 12, chunk_header = 8;
  const auto text = chunk(bytes, header, json_chunk);
  try {
    return points_in(json::parse(text.begin(), text.end()),
                     chunk(bytes, header + chunk_header + text.size(), binary_chunk));
  } catch (const json::exception&) {
    throw Error("its JSON is not that of a mesh");
  }
}

}  // namespace slipstream
