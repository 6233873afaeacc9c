#include <iterator>
#include <string>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/io/detail/point_formats.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

std::string ply_file(const Surface& surface) {
  std::string file = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment slipstream, camera frame, mm\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "{}property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      surface.vertices.size(), ply_intensity, surface.triangles.size());
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    append_numbers(file, surface.vertices[i], double{surface.intensity[i]});
    file.append(3, static_cast<char>(grey_level(surface.intensity[i])));
  }
  for (const auto& triangle : surface.triangles) {
    file += '\3';
    append_numbers(file, triangle);
  }
  return file;
}

std::string stl_file(const Surface& surface) {
  std::string file = "slipstream, camera frame, mm";
  file.resize(80);
  append_numbers(file, static_cast<std::uint32_t>(surface.triangles.size()));
  for (const auto& [a, b, c] : surface.triangles) {
    const Eigen::Vector3f &first = surface.vertices[a], &second = surface.vertices[b],
                          &third = surface.vertices[c];
    append_numbers(file, (second - first).cross(third - first).normalized().eval(), first, second,
                   third, std::uint16_t{0});
  }
  return file;
}

std::string obj_file(const Surface& surface, const std::string& materials) {
  std::string file =
      fmt::format("# slipstream, camera frame, mm\nmtllib {}\nusemtl camera\n", materials);
  const auto out = std::back_inserter(file);
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    const Eigen::Vector3f& at = surface.vertices[i];
    const float share = surface.intensity[i] / 255;
    fmt::format_to(out, "v {:.6f} {:.6f} {:.6f} {:.5f} {:.5f} {:.5f}\n", at.x(), at.y(), at.z(),
                   share, share, share);
  }
  for (const Eigen::Vector2f& at : surface.texture) {
    fmt::format_to(out, "vt {:.7f} {:.7f}\n", at.x(), 1 - at.y());
  }
  for (const auto& [a, b, c] : surface.triangles) {
    fmt::format_to(out, "f {0}/{0} {1}/{1} {2}/{2}\n", a + 1, b + 1, c + 1);
  }
  return file;
}

void write_obj(const fs::path& path, const Surface& surface) {
  const std::vector<fs::path> beside = files_beside(path);
  const fs::path &picture = beside[0], &materials = beside[1];
  write_image(picture, surface.picture);
  write_file(materials, fmt::format("newmtl camera\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd {}\n",
                                    picture.filename().string()));
  write_file(path, obj_file(surface, materials.filename().string()));
}

}  // namespace

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
  if (surface.triangles.empty()) {
    throw Error(
        fmt::format("{}: no points of neighbouring pixels to make a mesh of", path.string()));
  }
  const std::string extension = lower_case_extension(path);
  if (extension == ".obj") {
    write_obj(path, surface);
  } else {
    write_file(path, extension == ".ply"   ? ply_file(surface)
                     : extension == ".stl" ? stl_file(surface)
                                           : glb_file(surface));
  }
}

}  // namespace slipstream
