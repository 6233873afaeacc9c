#include "slipstream/io/cloud_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/ply_elements.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

static_assert(std::endian::native == std::endian::little,
              "clouds are written as they lie in memory");

void append(std::string& bytes, float value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// What stands behind x y z intensity, each by its name in PLY and in PCD.
struct Extra {
  const char* ply_name;
  const char* pcd_name;
  const Image<float>& values;
};

std::vector<Extra> extras_of(const CloudExtras& extras) {
  std::vector<Extra> all;
  if (const Normals* normals = extras.normals) {
    all.push_back({"nx", "normal_x", normals->x});
    all.push_back({"ny", "normal_y", normals->y});
    all.push_back({"nz", "normal_z", normals->z});
  }
  if (const Uncertainty* sigma = extras.uncertainty) {
    all.push_back({"sigma_coordinate", "sigma_coordinate", sigma->coordinate});
    all.push_back({"sigma_x", "sigma_x", sigma->x});
    all.push_back({"sigma_y", "sigma_y", sigma->y});
    all.push_back({"sigma_z", "sigma_z", sigma->z});
  }
  return all;
}

/// The remarks as comments of a header, a line each.
std::string comments_of(const std::vector<std::string>& remarks, std::string_view mark) {
  std::string lines;
  for (std::string remark : remarks) {
    std::replace_if(
        remark.begin(), remark.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    lines += fmt::format("{} {}\n", mark, remark);
  }
  return lines;
}

/// x y z intensity and the extras of one pixel, as 32-bit floats.
void append_point(std::string& bytes, const Cloud& cloud, const std::vector<Extra>& extras,
                  int column, int row) {
  append(bytes, cloud.x(column, row));
  append(bytes, cloud.y(column, row));
  append(bytes, cloud.z(column, row));
  append(bytes, cloud.intensity(column, row));
  for (const Extra& extra : extras) append(bytes, extra.values(column, row));
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

std::string ply_file(const Cloud& cloud, const std::vector<Extra>& extras,
                     const std::vector<std::string>& remarks) {
  std::string file = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment slipstream, camera frame, mm\n{}"
      "obj_info num_cols {}\nobj_info num_rows {}\nelement vertex {}\n",
      comments_of(remarks, "comment"), cloud.size().width, cloud.size().height, point_count(cloud));
  file += "property float x\nproperty float y\nproperty float z\nproperty float intensity\n";
  for (const Extra& extra : extras) file += fmt::format("property float {}\n", extra.ply_name);
  file += "end_header\n";
  for_each_point(cloud,
                 [&](int column, int row) { append_point(file, cloud, extras, column, row); });
  return file;
}

std::string pcd_file(const Cloud& cloud, const std::vector<Extra>& extras,
                     const std::vector<std::string>& remarks) {
  std::string fields, sizes, types, counts;
  for (const Extra& extra : extras) {
    fields += fmt::format(" {}", extra.pcd_name);
    sizes += " 4";
    types += " F";
    counts += " 1";
  }
  std::string file = fmt::format(
      "# .PCD v0.7 - slipstream, camera frame, mm\n{}VERSION 0.7\nFIELDS x y z intensity{}\n"
      "SIZE 4 4 4 4{}\nTYPE F F F F{}\nCOUNT 1 1 1 1{}\nWIDTH {}\nHEIGHT {}\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      comments_of(remarks, "#"), fields, sizes, types, counts, cloud.size().width,
      cloud.size().height, cloud.z.pixel_count());
  for_each_pixel(cloud,
                 [&](int column, int row) { append_point(file, cloud, extras, column, row); });
  return file;
}

std::string xyz_file(const Cloud& cloud) {
  std::string file;
  for_each_point(cloud, [&](int column, int row) {
    fmt::format_to(std::back_inserter(file), "{:.6f} {:.6f} {:.6f} {:.3f}\n", cloud.x(column, row),
                   cloud.y(column, row), cloud.z(column, row), cloud.intensity(column, row));
  });
  return file;
}

/// A vertex of a PLY file as far as a cloud has use for it.
struct Vertex {
  double x = 0, y = 0, z = 0, intensity = 0;
};

/// Where a property of that name goes, and how much of it.
struct Target {
  double Vertex::*field = nullptr;
  double share = 1;
};

Target target_of(const ply::Property& property) {
  if (property.count_type) return {};
  if (property.name == "x") return {&Vertex::x};
  if (property.name == "y") return {&Vertex::y};
  if (property.name == "z") return {&Vertex::z};
  if (property.name == "intensity" || property.name == "scalar_intensity") {
    return {&Vertex::intensity};
  }
  // The weights of the luminance of ITU-R BT.601.
  if (property.name == "red") return {&Vertex::intensity, 0.299};
  if (property.name == "green") return {&Vertex::intensity, 0.587};
  if (property.name == "blue") return {&Vertex::intensity, 0.114};
  return {};
}

/// The targets of an element's properties; where it has an intensity, its colours have none.
std::vector<Target> targets_of(const ply::Element& element) {
  std::vector<Target> targets;
  bool has_intensity = false;
  for (const ply::Property& property : element.properties) {
    targets.push_back(target_of(property));
    const Target& target = targets.back();
    has_intensity |= target.field == &Vertex::intensity && target.share == 1;
  }
  for (Target& target : targets) {
    if (has_intensity && target.share != 1) target = {};
  }
  return targets;
}

std::vector<Vertex> ply_vertices(std::span<const std::uint8_t> bytes) {
  ply::Reader reader(bytes);
  std::vector<Vertex> vertices;
  for (const ply::Element& element : ply::read_header(reader)) {
    if (element.properties.empty()) continue;
    const std::vector<Target> targets = targets_of(element);
    for (std::size_t i = 0; i < element.count; ++i) {
      Vertex vertex;
      for (std::size_t k = 0; k < targets.size(); ++k) {
        const std::vector<double> numbers = ply::read_property(element.properties[k], reader);
        if (targets[k].field != nullptr) vertex.*targets[k].field += targets[k].share * numbers[0];
      }
      const bool finite =
          std::isfinite(vertex.x) && std::isfinite(vertex.y) && std::isfinite(vertex.z);
      if (element.name == "vertex" && finite) vertices.push_back(vertex);
    }
  }
  return vertices;
}

}  // namespace

Cloud read_cloud(const fs::path& path) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  std::vector<Vertex> vertices;
  try {
    vertices = ply_vertices(bytes);
  } catch (const Error& error) {
    throw Error(fmt::format("{} is not a good PLY file: {}", path.string(), error.what()));
  }
  if (vertices.empty()) throw Error(fmt::format("{}: no point in it", path.string()));
  Cloud cloud({static_cast<int>(vertices.size()), 1});
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    cloud.x.begin()[i] = static_cast<float>(vertices[i].x);
    cloud.y.begin()[i] = static_cast<float>(vertices[i].y);
    cloud.z.begin()[i] = static_cast<float>(vertices[i].z);
    cloud.intensity.begin()[i] = static_cast<float>(vertices[i].intensity);
    cloud.validity.begin()[i] = Validity::valid;
  }
  return cloud;
}

void require_cloud_ending(const fs::path& path) {
  const std::string extension = lower_case_extension(path);
  if (extension != ".ply" && extension != ".pcd" && extension != ".xyz") {
    throw Error(fmt::format("{}: no cloud format has the ending '{}'; use .ply, .pcd or .xyz",
                            path.string(), extension));
  }
}

void write_cloud(const fs::path& path, const Cloud& cloud, const CloudExtras& extras) {
  require_cloud_ending(path);
  const std::string extension = lower_case_extension(path);
  if (extension == ".ply") {
    write_file(path, ply_file(cloud, extras_of(extras), extras.remarks));
  } else if (extension == ".pcd") {
    write_file(path, pcd_file(cloud, extras_of(extras), extras.remarks));
  } else {
    write_file(path, xyz_file(cloud));
  }
}

}  // namespace slipstream
