// Mesh formats: writers, and the readers that cloud_file.cpp lacks.
#include "io/mesh_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/compressed_pictures.h"
#include "io/file.h"
#include "io/frame_title.h"
#include "io/glb_file.h"
#include "io/point_elements.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// A vertex's colour, or its intensity as grey.
Colour colour_of(const Surface& surface, std::size_t vertex) {
  if (!surface.colour.empty()) return surface.colour[vertex];
  const std::uint8_t grey = grey_level(surface.intensity[vertex]);
  return {grey, grey, grey};
}

std::string ply_file(const Surface& surface) {
  std::string file = fmt::format(
      "ply\nformat binary_little_endian 1.0\n{}"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "{}property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      frame_comments(surface.frame.get(), "comment"), surface.vertices.size(), ply_intensity,
      surface.triangles.size());

  // The vertices, with a double intensity and three colours.
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    append_numbers(file, surface.vertices[i], double{surface.intensity[i]}, colour_of(surface, i));
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
    std::array<float, 3> shares{};
    shares.fill(surface.intensity[i] / 255);
    if (!surface.colour.empty()) {
      const auto [red, green, blue] = surface.colour[i];
      shares = {red / 255.0F, green / 255.0F, blue / 255.0F};
    }

    fmt::format_to(out, "v {:.6f} {:.6f} {:.6f} {:.5f} {:.5f} {:.5f}\n", at.x(), at.y(), at.z(),
                   shares[0], shares[1], shares[2]);
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

/// The texture as a PNG, sRGB.
std::vector<std::uint8_t> texture_of(const Surface& surface) {
  const Image<Colour>& coloured = surface.colour_picture;
  if (coloured.empty()) return png_file_of(surface.picture);

  static_assert(sizeof(Colour) == 3);
  const Size samples{3 * coloured.width(), coloured.height()};
  const auto* const first = reinterpret_cast<const std::uint8_t*>(coloured.begin());
  return png_file_of(PictureView(ImageView<const std::uint8_t>(first, samples), 3));
}

void write_obj(const fs::path& path, const Surface& surface) {
  const std::vector<fs::path> beside = files_beside(path);
  const std::string picture = beside[0].filename().string();

  // Colours of vertices without a colour picture would disappear under the grey one.
  const bool only_vertices = !surface.colour.empty() && surface.colour_picture.empty();
  std::string material = "newmtl camera\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\n";
  if (!only_vertices) material += fmt::format("map_Kd {}\n", picture);

  OutputFile texture(beside[0]), materials(beside[1]), object(path);
  texture.write({texture_of(surface)});
  materials.write({bytes_of(material)});
  object.write({bytes_of(obj_file(surface, beside[1].filename().string()))});

  OutputFile::keep_together({&texture, &materials, &object});
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
  bytes = without_mark(bytes);
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
    if (coloured) {
      point.colour = {255 * colours[i], 255 * colours[i + 1], 255 * colours[i + 2]};
      point.intensity = 255 * luminance(colours[i], colours[i + 1], colours[i + 2]);
    }
  }
  stored.has_colour = any_colour(stored.points);

  for (const tinyobj::shape_t& shape : shapes) {
    const auto& corners = shape.mesh.indices;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
      stored.triangles.push_back(
          {corners[i].vertex_index, corners[i + 1].vertex_index, corners[i + 2].vertex_index});
    }
  }

  return stored;
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
