// Mesh formats: writers, and the readers that cloud_file.cpp lacks.
#include "io/mesh_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <tiny_obj_loader.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/compressed_pictures.h"
#include "io/file.h"
#include "io/frame_title.h"
#include "io/gltf_frame.h"
#include "io/point_elements.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

std::string ply_file(const Surface& surface) {
  std::string file = fmt::format(
      "ply\nformat binary_little_endian 1.0\n{}"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "{}property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      frame_comments(surface.frame.get(), "comment"), surface.vertices.size(), ply_intensity,
      surface.triangles.size());

  // The vertices, with a double intensity and three equal colours.
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    append_numbers(file, surface.vertices[i], double{surface.intensity[i]});
    file.append(3, static_cast<char>(grey_level(surface.intensity[i])));
  }

  // The triangles, each with its number of corners.
  for (const auto& triangle : surface.triangles) {
    file += '\3';
    append_numbers(file, triangle);
  }

  return file;
}

std::string stl_file(const Surface& surface) {
  // A header of 80 bytes, and the number of triangles.
  std::string file = frame_title(surface.frame.get());
  file.resize(80);
  append_numbers(file, static_cast<std::uint32_t>(surface.triangles.size()));

  // The normal, the corners and an unused word.
  for (const auto& [a, b, c] : surface.triangles) {
    const Eigen::Vector3f &first = surface.vertices[a], &second = surface.vertices[b],
                          &third = surface.vertices[c];
    append_numbers(file, (second - first).cross(third - first).normalized().eval(), first, second,
                   third, std::uint16_t{0});
  }

  return file;
}

std::string obj_file(const Surface& surface, const std::string& materials) {
  std::string file = fmt::format("{}mtllib {}\nusemtl camera\n",
                                 frame_comments(surface.frame.get(), "#"), materials);

  const auto out = std::back_inserter(file);

  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    const Eigen::Vector3f& at = surface.vertices[i];
    const float share = surface.intensity[i] / 255;
    fmt::format_to(out, "v {:.6f} {:.6f} {:.6f} {:.5f} {:.5f} {:.5f}\n", at.x(), at.y(), at.z(),
                   share, share, share);
  }

  // OBJ measures the texture from the bottom.
  for (const Eigen::Vector2f& at : surface.texture) {
    fmt::format_to(out, "vt {:.7f} {:.7f}\n", at.x(), 1 - at.y());
  }

  // Vertices and texture coordinates are counted from 1 and have the same numbers.
  for (const auto& [a, b, c] : surface.triangles) {
    fmt::format_to(out, "f {0}/{0} {1}/{1} {2}/{2}\n", a + 1, b + 1, c + 1);
  }

  return file;
}

void write_obj(const fs::path& path, const Surface& surface) {
  const std::vector<fs::path> beside = files_beside(path);
  const std::string picture = beside[0].filename().string();

  OutputFile texture(beside[0]), materials(beside[1]), object(path);
  texture.write({png_file_of(surface.picture)});
  materials.write(
      {bytes_of(fmt::format("newmtl camera\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd {}\n", picture))});
  object.write({bytes_of(obj_file(surface, beside[1].filename().string()))});

  OutputFile::keep_together({&texture, &materials, &object});
}

// Constants of glTF 2.0.
constexpr std::uint32_t glb_magic = 0x46546C67, version = 2;
constexpr std::uint32_t json_chunk = 0x4E4F534A, binary_chunk = 0x004E4942;
constexpr int float32 = 5126, uint32 = 5125;
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

json document_of(const Surface& surface, Binary& binary) {
  // 1. The numbers, in the order in which the mesh below refers to them: 0 to 3.
  const json accessors{
      positions_of(surface, binary),
      binary.accessor(surface.texture, "VEC2", float32, vertex_buffer),
      binary.accessor(surface.intensity, "SCALAR", float32, vertex_buffer),
      binary.accessor(surface.triangles, "SCALAR", uint32, index_buffer),
  };

  // 2. The texture, as a PNG.
  const std::vector<std::uint8_t> picture = png_file_of(surface.picture);
  const std::size_t picture_view = binary.append(picture.data(), picture.size());

  // 3. The scene of one mesh. A rough surface without metal shows the texture as it is.
  return {
      {"asset", {{"version", "2.0"}, {"generator", "slipstream"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0}}}}},
      {"nodes", json::array({gltf_node_of(surface.frame.get())})},
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
template <std::size_t components>
std::vector<std::array<float, components>> numbers_of(const json& document, const json& accessor_at,
                                                      std::span<const std::uint8_t> binary) {
  const json& accessor = document.at("accessors").at(count_of(accessor_at));
  const json& view = document.at("bufferViews").at(count_of(accessor.at("bufferView")));

  throw_if(accessor.at("componentType") != float32 || view.contains("byteStride"),
           "its vertices are not contiguous 32-bit float");

  // The count is checked against the file before memory is allocated.
  std::vector<std::array<float, components>> numbers;
  const std::size_t count = count_of(accessor.at("count"));
  if (count > binary.size() / sizeof(numbers[0])) throw Error("it is truncated");
  numbers.resize(count);

  const auto offset_in = [](const json& of) { return count_of(of.value("byteOffset", json(0U))); };
  const auto of_view = part(binary, offset_in(view), count_of(view.at("byteLength")));
  const auto bytes = part(of_view, offset_in(accessor), count * sizeof(numbers[0]));

  if (count > 0) std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
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

      for (std::size_t i = 0; i < positions.size(); ++i) {
        const auto& [x, y, z] = positions[i];
        // The reverse of positions_of.
        stored.points.push_back({1000.0 * x, up * y, up * z, intensity[i][0]});
      }
    }
  }

  return stored;
}

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

/// The number of the vertex at a corner of an OBJ face, such as 7 of "7/3/2".
std::string_view vertex_of(std::string_view corner) {
  constexpr std::size_t longest = 20;
  const std::string_view vertex = corner.substr(0, corner.find('/'));
  throw_if(vertex.size() > longest, "'{}' is not the number of a vertex",
           vertex.substr(0, longest));
  return vertex;
}

/// Appends an OBJ face whose corners are these words.
void append_face(std::string& lines, std::span<const std::string_view> corners) {
  lines += 'f';
  for (const std::string_view corner : corners) lines.append(" ").append(vertex_of(corner));
  lines += '\n';
}

/// The lines of an OBJ file with vertices and faces. Cutting a face into triangles takes time in
/// the cube of its corners, so those of many corners are cut here, as if convex. Other lines are
/// left out: groups and tags together would take time in their square.
std::string vertices_and_faces(std::string_view text) {
  constexpr std::size_t most_corners = 32;

  std::string lines;
  while (!text.empty()) {
    std::string_view line = text.substr(0, text.find_first_of("\r\n"));
    text.remove_prefix(std::min(line.size() + 1, text.size()));

    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (line.starts_with("v ") || line.starts_with("v\t")) lines.append(line).push_back('\n');
    if (!line.starts_with("f ") && !line.starts_with("f\t")) continue;

    // The first word is the f.
    const std::vector<std::string_view> words = words_of(line);
    if (words.size() - 1 <= most_corners) {
      append_face(lines, std::span(words).subspan(1));
      continue;
    }

    for (std::size_t n = 3; n < words.size(); ++n) {  // triangle fan
      append_face(lines, std::array{words[1], words[n - 1], words[n]});
    }
  }

  return lines;
}

}  // namespace

StoredPoints stl_points(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t header = 80, first = header + 4, of_triangle = 50, of_vector = 12;
  if (bytes.size() < first) throw Error("it is truncated");

  const auto count = number_at<std::uint32_t>(bytes, header);
  throw_if(bytes.size() - first != count * of_triangle,
           "its length does not match a binary STL with its number of triangles");

  std::vector<std::array<float, 3>> corners;
  for (std::size_t at = first; at < bytes.size(); at += of_triangle) {
    for (std::size_t k = 1; k < 4; ++k) {  // the first vector is the normal
      const auto corner = number_at<std::array<float, 3>>(bytes, at + k * of_vector);
      if (std::isfinite(corner[0] + corner[1] + corner[2])) corners.push_back(corner);
    }
  }

  // Neighbouring triangles share corners.
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());

  StoredPoints stored;
  for (const auto& [x, y, z] : corners) stored.points.push_back({.x = x, .y = y, .z = z});

  FrameTitle title;
  title.read({reinterpret_cast<const char*>(bytes.data()), header});
  stored.frame = title.frame();

  return stored;
}

StoredPoints obj_points(std::span<const std::uint8_t> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::istringstream stream(vertices_and_faces(text));
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;

  constexpr bool triangulate = true, white_where_no_colour = false;
  throw_if(!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &stream, nullptr,
                             triangulate, white_where_no_colour),
           "it is not an OBJ file");

  StoredPoints stored;
  stored.frame = frame_of_comments(text);
  const auto& at = attributes.vertices;
  const auto& colours = attributes.colors;  // 0 to 1
  const bool coloured = colours.size() == at.size();

  for (std::size_t i = 0; i + 2 < at.size(); i += 3) {
    StoredPoint& point = stored.points.emplace_back();
    point.x = at[i];
    point.y = at[i + 1];
    point.z = at[i + 2];
    if (coloured) point.intensity = 255 * luminance(colours[i], colours[i + 1], colours[i + 2]);
  }

  for (const tinyobj::shape_t& shape : shapes) {
    const auto& corners = shape.mesh.indices;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
      stored.triangles.push_back(
          {corners[i].vertex_index, corners[i + 1].vertex_index, corners[i + 2].vertex_index});
    }
  }

  return stored;
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

void require_mesh_ending(const fs::path& path) {
  require_ending(path, "mesh format", {".ply", ".stl", ".obj", ".glb"});
}

std::vector<fs::path> files_beside(const fs::path& surface) {
  if (lower_case_extension(surface) != ".obj") return {};
  const fs::path name = surface.parent_path() / surface.stem();
  return {name.string() + "-texture.png", name.string() + ".mtl"};
}

void write_surface(const fs::path& path, const Surface& surface) {
  require_mesh_ending(path);
  throw_if(surface.triangles.empty(), "{}: no neighbouring points to make a mesh of",
           path.string());

  const std::string extension = lower_case_extension(path);
  if (extension == ".obj") return write_obj(path, surface);

  write_file(path, extension == ".ply"   ? ply_file(surface)
                   : extension == ".stl" ? stl_file(surface)
                                         : glb_file(surface));
}

}  // namespace slipstream
