#include "slipstream/io/cloud_file.h"

#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

static_assert(std::endian::native == std::endian::little,
              "clouds are written as they lie in memory");

void append(std::string& bytes, float value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// x y z intensity [nx ny nz] of one pixel, as 32-bit floats.
void append_point(std::string& bytes, const Cloud& cloud, const Normals* normals, int column,
                  int row) {
  append(bytes, static_cast<float>(cloud.x(column, row)));
  append(bytes, static_cast<float>(cloud.y(column, row)));
  append(bytes, static_cast<float>(cloud.z(column, row)));
  append(bytes, cloud.intensity(column, row));
  if (normals == nullptr) return;
  append(bytes, normals->x(column, row));
  append(bytes, normals->y(column, row));
  append(bytes, normals->z(column, row));
}

template <class Visit>
void for_each_pixel(const Cloud& cloud, const Visit& visit) {
  for (int row = 0; row < cloud.size().height; ++row) {
    for (int column = 0; column < cloud.size().width; ++column) visit(column, row);
  }
}

template <class Visit>
void for_each_point(const Cloud& cloud, const Visit& visit) {
  for_each_pixel(cloud, [&](int column, int row) {
    if (cloud.validity(column, row) == Validity::valid) visit(column, row);
  });
}

std::string ply(const Cloud& cloud, const Normals* normals) {
  std::string file = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment slipstream, camera frame, mm\n"
      "obj_info num_cols {}\nobj_info num_rows {}\nelement vertex {}\n",
      cloud.size().width, cloud.size().height, point_count(cloud));
  file += "property float x\nproperty float y\nproperty float z\nproperty float intensity\n";
  if (normals != nullptr) file += "property float nx\nproperty float ny\nproperty float nz\n";
  file += "end_header\n";
  for_each_point(cloud,
                 [&](int column, int row) { append_point(file, cloud, normals, column, row); });
  return file;
}

std::string pcd(const Cloud& cloud, const Normals* normals) {
  const bool with_normals = normals != nullptr;
  std::string file = fmt::format(
      "# .PCD v0.7 - slipstream, camera frame, mm\nVERSION 0.7\nFIELDS x y z intensity{}\n"
      "SIZE 4 4 4 4{}\nTYPE F F F F{}\nCOUNT 1 1 1 1{}\nWIDTH {}\nHEIGHT {}\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      with_normals ? " normal_x normal_y normal_z" : "", with_normals ? " 4 4 4" : "",
      with_normals ? " F F F" : "", with_normals ? " 1 1 1" : "", cloud.size().width,
      cloud.size().height, cloud.z.pixel_count());
  for_each_pixel(cloud,
                 [&](int column, int row) { append_point(file, cloud, normals, column, row); });
  return file;
}

std::string xyz(const Cloud& cloud) {
  std::string file;
  for_each_point(cloud, [&](int column, int row) {
    fmt::format_to(std::back_inserter(file), "{:.6f} {:.6f} {:.6f} {:.3f}\n", cloud.x(column, row),
                   cloud.y(column, row), cloud.z(column, row), cloud.intensity(column, row));
  });
  return file;
}

}  // namespace

void require_cloud_ending(const fs::path& path) {
  const std::string extension = lower_case_extension(path);
  if (extension != ".ply" && extension != ".pcd" && extension != ".xyz") {
    throw Error(fmt::format("{}: no cloud format has the ending '{}'; use .ply, .pcd or .xyz",
                            path.string(), extension));
  }
}

void write_cloud(const fs::path& path, const Cloud& cloud, const Normals* normals) {
  require_cloud_ending(path);
  const std::string extension = lower_case_extension(path);
  if (extension == ".ply") {
    write_file(path, ply(cloud, normals));
  } else if (extension == ".pcd") {
    write_file(path, pcd(cloud, normals));
  } else {
    write_file(path, xyz(cloud));
  }
}

}  // namespace slipstream
