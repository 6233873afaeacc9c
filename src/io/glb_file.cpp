#include "io/glb_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "base/numbers.h"
#include "base/srgb.h"
#include "base/throw_if-inl.h"
#include "io/compressed_pictures.h"
#include "io/file.h"
#include "io/gltf_frame.h"
#include "io/point_elements.h"

namespace slipstream {
namespace {

using nlohmann::json;

// Constants of glTF 2.0.
constexpr std::uint32_t glb_magic = 0x46546C67, version = 2;
constexpr std::uint32_t json_chunk = 0x4E4F534A, binary_chunk = 0x004E4942;
constexpr int float32 = 5126, uint32 = 5125, uint16 = 5123;
constexpr int vertex_buffer = 34962, index_buffer = 34963;
constexpr int linear = 9729, clamped = 33071;
constexpr std::size_t glb_header = 12, chunk_header = 8;

/// From mm, y down and z forward, to metres, y up and z towards the camera.
Eigen::Vector3f to_gltf(const Eigen::Vector3f& point) {
  return Eigen::Vector3f(point.x(), -point.y(), -point.z()) / 1000;
}

/// The binary part of the file, and its buffer views.
struct Binary {
  std::string bytes;
  json views = json::array();

  /// Returns the number of the view.
  std::size_t append(const void* data, std::size_t size, int target = 0) {
    views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
    if (target != 0) views.back()["target"] = target;

    // glTF requires views that begin at a multiple of four bytes.
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
  std::transform(surface.vertices.begin(), surface.vertices.end(), positions.begin(),
                 [&](const Eigen::Vector3f& vertex) -> Eigen::Vector3f {
                   return surface.frame ? vertex / 1000 : to_gltf(vertex);
                 });

  // glTF requires the bounds of positions.
  Eigen::AlignedBox3f bounds;
  for (const Eigen::Vector3f& position : positions) bounds.extend(position);

  json accessor = binary.accessor(positions, "VEC3", float32, vertex_buffer);
  accessor["min"] = {bounds.min().x(), bounds.min().y(), bounds.min().z()};
  accessor["max"] = {bounds.max().x(), bounds.max().y(), bounds.max().z()};
  return accessor;
}

/// Red, green, blue and opacity of the vertices: linear light, as glTF has it. Four numbers, since
/// an element must begin at a multiple of four bytes.
json colours_of(const Surface& surface, Binary& binary) {
  std::vector<std::array<std::uint16_t, 4>> colours;
  for (const auto& [red, green, blue] : surface.colour) {
    colours.push_back({linear_16_bits(red), linear_16_bits(green), linear_16_bits(blue), 65535});
  }

  json accessor = binary.accessor(colours, "VEC4", uint16, vertex_buffer);
  accessor["normalized"] = true;
  return accessor;
}

/// The grey texture, as a PNG, in the parts of the document that refer to it.
void add_texture(const Surface& surface, Binary& binary, json& document) {
  const std::vector<std::uint8_t> picture = png_file_of(surface.picture);
  const std::size_t view = binary.append(picture.data(), picture.size());

  document["textures"] = {{{"source", 0}, {"sampler", 0}}};
  document["samplers"] = {
      {{"magFilter", linear}, {"minFilter", linear}, {"wrapS", clamped}, {"wrapT", clamped}}};
  document["images"] = {{{"bufferView", view}, {"mimeType", "image/png"}}};
  document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
}

json document_of(const Surface& surface, Binary& binary) {
  // 1. The numbers, in the order in which the mesh below refers to them: 0 to 3.
  json accessors{
      positions_of(surface, binary),
      binary.accessor(surface.texture, "VEC2", float32, vertex_buffer),
      binary.accessor(surface.intensity, "SCALAR", float32, vertex_buffer),
      binary.accessor(surface.triangles, "SCALAR", uint32, index_buffer),
  };

  json attributes{{"POSITION", 0}, {"TEXCOORD_0", 1}, {"_INTENSITY", 2}};
  if (!surface.colour.empty()) {
    attributes["COLOR_0"] = accessors.size();
    accessors.push_back(colours_of(surface, binary));
  }

  // 2. The scene of one mesh. A rough surface without metal shows the colours as they are.
  json document{
      {"asset", {{"version", "2.0"}, {"generator", "slipstream"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", json::array({gltf_node_of(surface.frame.get())})},
      {"meshes",
       {{{"primitives", {{{"attributes", attributes}, {"indices", 3}, {"material", 0}}}}}}},
      {"materials",
       {{{"doubleSided", true},
         {"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}}}},
      {"accessors", accessors},
  };

  // 3. A texture, unless the vertices have the colours of all pixels: it would multiply them.
  if (surface.colour.empty()) add_texture(surface, binary, document);
  document["bufferViews"] = binary.views;
  document["buffers"] = {{{"byteLength", binary.bytes.size()}}};
  return document;
}

/// `size` bytes from `offset`. Throws Error if they are out of range.
std::span<const std::uint8_t> part(std::span<const std::uint8_t> bytes, std::size_t offset,
                                   std::size_t size) {
  if (offset > bytes.size() || size > bytes.size() - offset) throw Error("it is truncated");
  return bytes.subspan(offset, size);
}

std::uint32_t count_at(std::span<const std::uint8_t> bytes, std::size_t offset) {
  return number_at<std::uint32_t>(part(bytes, offset, sizeof(std::uint32_t)), 0);
}

std::size_t count_of(const json& number) {
  if (!number.is_number_unsigned()) throw Error("a count is not a number");
  return number.get<std::size_t>();
}

/// The chunk at `offset`, which must be of this kind.
std::span<const std::uint8_t> chunk(std::span<const std::uint8_t> bytes, std::size_t offset,
                                    std::uint32_t kind) {
  if (count_at(bytes, offset + 4) != kind) throw Error("a chunk has an unexpected type");
  return part(bytes, offset + 8, count_at(bytes, offset));
}

/// The numbers of an accessor, `components` for each element.
template <std::size_t components, class Number = float>
std::vector<std::array<Number, components>> numbers_of(const json& document,
                                                       const json& accessor_at,
                                                       std::span<const std::uint8_t> binary) {
  const json& accessor = document.at("accessors").at(count_of(accessor_at));
  const json& view = document.at("bufferViews").at(count_of(accessor.at("bufferView")));

  constexpr bool is_float = std::is_same_v<Number, float>;
  throw_if(
      accessor.at("componentType") != (is_float ? float32 : uint16) || view.contains("byteStride"),
      "its vertices are not contiguous 32-bit float");

  // The count is checked against the file before memory is allocated.
  std::vector<std::array<Number, components>> numbers;
  const std::size_t count = count_of(accessor.at("count"));
  if (count > binary.size() / sizeof(numbers[0])) throw Error("it is truncated");
  numbers.resize(count);

  const auto offset_in = [](const json& of) { return count_of(of.value("byteOffset", json(0U))); };
  const auto of_view = part(binary, offset_in(view), count_of(view.at("byteLength")));
  const auto bytes = part(of_view, offset_in(accessor), count * sizeof(numbers[0]));

  if (count > 0) std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

/// The vertices' colours, sRGB, 0 to 255, if they are of 16 bits as written here; otherwise empty.
std::vector<std::array<float, 3>> colours_in(const json& document, const json& attributes,
                                             std::span<const std::uint8_t> binary,
                                             std::size_t count) {
  if (!attributes.contains("COLOR_0")) return {};
  const json& accessor = document.at("accessors").at(count_of(attributes["COLOR_0"]));
  if (accessor.at("componentType") != uint16 || accessor.at("type") != "VEC4") return {};

  const auto stored = numbers_of<4, std::uint16_t>(document, attributes["COLOR_0"], binary);
  throw_if(stored.size() != count, "a primitive has {} vertices, but {} colours", count,
           stored.size());

  std::vector<std::array<float, 3>> colours(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      colours[i][c] = static_cast<float>(std::round(255 * srgb_of_linear(stored[i][c] / 65535.0)));
    }
  }
  return colours;
}

StoredPoints points_in(const json& document, std::span<const std::uint8_t> binary) {
  StoredPoints stored;
  stored.frame = gltf_frame_in(document);
  const double up = stored.frame ? 1000 : -1000;  // in the camera's frame y is down, z forward
  std::set<std::size_t> taken;

  for (const json& mesh : document.at("meshes")) {
    for (const json& primitive : mesh.at("primitives")) {
      // Primitives may share their vertices, which are taken once.
      const json& attributes = primitive.at("attributes");
      const json& vertices = attributes.at("POSITION");
      if (!taken.insert(count_of(vertices)).second) continue;

      const auto positions = numbers_of<3>(document, vertices, binary);
      std::vector<std::array<float, 1>> intensity(positions.size());
      if (attributes.contains("_INTENSITY")) {
        intensity = numbers_of<1>(document, attributes["_INTENSITY"], binary);
      }
      throw_if(intensity.size() != positions.size(),
               "a primitive has {} vertices, but {} intensities", positions.size(),
               intensity.size());

      // Vertices of their own take at least their bytes in the file.
      const std::size_t count = stored.points.size() + positions.size();
      throw_if(count > binary.size() / sizeof(positions[0]),
               "its vertices overlap; they are more than its {} bytes hold", binary.size());

      const auto colours = colours_in(document, attributes, binary, positions.size());
      for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto& [x, y, z] = positions[i];
        // The reverse of positions_of.
        stored.points.push_back({1000.0 * x, up * y, up * z, intensity[i][0]});
        if (!colours.empty()) stored.points.back().colour = colours[i];
      }
    }
  }

  stored.has_colour = any_colour(stored.points);
  return stored;
}

}  // namespace

std::string glb_file(const Surface& surface) {
  // Chunks are padded to four bytes: the text with blanks, the numbers with zeros.
  Binary binary;
  std::string text = document_of(surface, binary).dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');

  std::string file;
  const auto size_of = [](std::size_t bytes) { return static_cast<std::uint32_t>(bytes); };
  append_numbers(file, glb_magic, version,
                 size_of(glb_header + 2 * chunk_header + text.size() + binary.bytes.size()),
                 size_of(text.size()), json_chunk);

  file += text;
  append_numbers(file, size_of(binary.bytes.size()), binary_chunk);
  return file + binary.bytes;
}

StoredPoints glb_points(std::span<const std::uint8_t> bytes) {
  throw_if(count_at(bytes, 0) != glb_magic || count_at(bytes, 4) != version,
           "it is not binary glTF 2.0");

  const auto text = chunk(bytes, glb_header, json_chunk);
  try {
    return points_in(json::parse(text.begin(), text.end()),
                     chunk(bytes, glb_header + chunk_header + text.size(), binary_chunk));
  } catch (const json::exception&) {
    throw Error("its JSON does not describe a mesh");
  }
}

}  // namespace slipstream
