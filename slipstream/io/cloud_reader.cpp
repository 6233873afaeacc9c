#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include "slipstream/base/error.h"
#include "slipstream/io/detail/point_formats.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace fs = std::filesystem;
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

/// The corners of the triangles of a binary STL file, each once, in no order.
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

/// Intensity is that of the colours.
StoredPoints obj_points(std::span<const std::uint8_t> bytes) {
  StoredPoints stored;
  const auto [attributes, shapes] = loaded_obj(bytes);
  const auto& at = attributes.vertices;
  const bool coloured = attributes.colors.size() == at.size();
  for (std::size_t i = 0; i + 2 < at.size(); i += 3) {
    stored.points.push_back({.x = at[i],
                             .y = at[i + 1],
                             .z = at[i + 2],
                             .intensity = coloured ? 255 * attributes.colors[i + 1] : 0});
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

/// The numbers of one property: one, or as many as a list has.
std::vector<double> read_property(const PlyProperty& property, NumberReader& reader) {
  const double count = property.count_type ? reader.number(*property.count_type) : 1;
  if (!(count >= 0 && count <= static_cast<double>(reader.left().size()))) {
    throw Error(fmt::format("a list of {} numbers does not fit into it", count));
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    numbers.push_back(reader.number(property.type));
  }
  return numbers;
}

/// Where a column of that name goes, and how much of it.
struct Target {
  double StoredPoint::*field = nullptr;
  double share = 1;
};

Target target_of(const PlyProperty& property) {
  // The weights of the luminance of ITU-R BT.601.
  static constexpr std::array<std::pair<std::string_view, Target>, 12> targets{
      {{"x", {&StoredPoint::x}},
       {"y", {&StoredPoint::y}},
       {"z", {&StoredPoint::z}},
       {"intensity", {&StoredPoint::intensity}},
       {"scalar_intensity", {&StoredPoint::intensity}},
       {"red", {&StoredPoint::intensity, 0.299}},
       {"green", {&StoredPoint::intensity, 0.587}},
       {"blue", {&StoredPoint::intensity, 0.114}},
       {"sigma_coordinate", {&StoredPoint::sigma_coordinate}},
       {"sigma_x", {&StoredPoint::sigma_x}},
       {"sigma_y", {&StoredPoint::sigma_y}},
       {"sigma_z", {&StoredPoint::sigma_z}}}};
  const auto* const found = std::find_if(targets.begin(), targets.end(), [&](const auto& target) {
    return target.first == property.name;
  });
  return found == targets.end() || property.count_type ? Target{} : found->second;
}

/// The targets of an element's properties; where it has an intensity, its colours have none.
std::vector<Target> targets_of(const PlyElement& element) {
  std::vector<Target> targets;
  bool has_intensity = false;
  for (const PlyProperty& property : element.properties) {
    targets.push_back(target_of(property));
    const Target& target = targets.back();
    has_intensity |= target.field == &StoredPoint::intensity && target.share == 1;
  }
  for (Target& target : targets) {
    if (has_intensity && target.share != 1) target = {};
  }
  return targets;
}

/// -1 where it is none.
int index_from(double number) {
  const bool index = number >= 0 && number <= std::numeric_limits<int>::max();
  return index && number == std::floor(number) ? static_cast<int>(number) : -1;
}

/// As a fan.
void add_triangles(const std::vector<double>& corners, StoredPoints& stored) {
  for (std::size_t i = 2; i < corners.size(); ++i) {
    stored.triangles.push_back(
        {index_from(corners[0]), index_from(corners[i - 1]), index_from(corners[i])});
  }
}

/// Reads past an element; keeps its points where it is of vertices, and its faces.
void read_element(const PlyElement& element, NumberReader& reader, StoredPoints& stored) {
  if (element.properties.empty()) return;
  const std::vector<Target> targets = targets_of(element);
  const bool vertices = element.name == "vertex";
  const auto lacks = [&](double StoredPoint::*field) {
    return std::none_of(targets.begin(), targets.end(),
                        [field](const Target& target) { return target.field == field; });
  };
  if (vertices && (lacks(&StoredPoint::x) || lacks(&StoredPoint::y) || lacks(&StoredPoint::z))) {
    throw Error("its points have no x, y and z");
  }
  for (std::size_t i = 0; i < element.count; ++i) {
    StoredPoint point;
    for (std::size_t k = 0; k < targets.size(); ++k) {
      const std::vector<double> numbers = read_property(element.properties[k], reader);
      if (targets[k].field != nullptr) point.*targets[k].field += targets[k].share * numbers[0];
      const std::string& name = element.properties[k].name;
      if (name == "vertex_indices" || name == "vertex_index") add_triangles(numbers, stored);
    }
    if (vertices) stored.points.push_back(point);
  }
  stored.has_sigma |= vertices && !lacks(&StoredPoint::sigma_z);
}

StoredPoints ply_points(std::span<const std::uint8_t> bytes) {
  NumberReader reader(bytes);
  StoredPoints stored;
  for (const PlyElement& element : read_ply_header(reader)) {
    read_element(element, reader, stored);
  }
  return stored;
}

/// The words of each line of a PCD header by its first word, which goes.
std::map<std::string, std::vector<std::string_view>, std::less<>> pcd_header(NumberReader& reader) {
  std::map<std::string, std::vector<std::string_view>, std::less<>> header;
  while (!header.contains("DATA")) {
    std::vector<std::string_view> words = words_of(reader.line());
    if (words.empty() || words[0].starts_with('#')) continue;
    const std::string key(words[0]);
    words.erase(words.begin());
    header[key] = std::move(words);
  }
  for (const char* key : {"FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "DATA"}) {
    if (header[key].empty()) throw Error(fmt::format("its header has no {}", key));
  }
  return header;
}

/// All fields of 32-bit float, one number each, as write_cloud and most others write them.
StoredPoints pcd_points(std::span<const std::uint8_t> bytes) {
  NumberReader reader(bytes);
  const auto header = pcd_header(reader);
  const auto all = [&](const char* key, std::string_view wanted) {
    const auto& words = header.at(key);
    return std::all_of(words.begin(), words.end(), [&](auto word) { return word == wanted; });
  };
  if (!all("SIZE", "4") || !all("TYPE", "F") || !all("COUNT", "1")) {
    throw Error("its fields are not all of one 32-bit float");
  }
  if (!all("DATA", "binary") && !all("DATA", "ascii")) {
    throw Error("its DATA are neither ascii nor binary");
  }
  if (all("DATA", "binary")) reader.set_format(NumberFormat::little_endian);
  PlyElement element{.name = "vertex", .properties = {}};
  for (const std::string_view field : header.at("FIELDS")) {
    element.properties.push_back({std::string(field), NumberType::float32, std::nullopt});
  }
  const std::size_t width = count_from(header.at("WIDTH")[0]);
  const std::size_t height = count_from(header.at("HEIGHT")[0]);
  if (std::max(width, height) > reader.left().size()) throw Error("it is truncated");
  element.count = width * height;
  StoredPoints stored;
  if (height > 1) stored.organised = {static_cast<int>(width), static_cast<int>(height)};
  read_element(element, reader, stored);
  return stored;
}

/// What a text of so many columns holds, as write_cloud writes it.
std::vector<std::string_view> names_of_columns(std::size_t count) {
  static constexpr std::array<std::string_view, 4> place{"x", "y", "z", "intensity"};
  static constexpr std::array<std::string_view, 4> sigma{"sigma_coordinate", "sigma_x", "sigma_y",
                                                         "sigma_z"};
  std::vector<std::string_view> names(count, "");
  const bool ours = count == 4 || count == 7 || count == 8 || count == 11;
  std::copy_n(place.begin(), std::min<std::size_t>(count, ours ? 4 : 3), names.begin());
  if (count == 8 || count == 11) std::copy(sigma.begin(), sigma.end(), names.end() - 4);
  return names;
}

StoredPoints xyz_points(std::span<const std::uint8_t> bytes) {
  NumberReader reader(bytes);
  NumberReader lines = reader;
  const std::size_t columns = lines.left().empty() ? 0 : words_of(lines.line()).size();
  PlyElement element{.name = "vertex", .count = 1, .properties = {}};
  for (const std::string_view name : names_of_columns(columns)) {
    element.properties.push_back({std::string(name), NumberType::float64, std::nullopt});
  }
  for (; !lines.left().empty(); ++element.count) {
    if (words_of(lines.line()).size() != columns) {
      throw Error(
          fmt::format("line {} has not the {} numbers of the first", element.count + 1, columns));
    }
  }
  StoredPoints stored;
  read_element(element, reader, stored);
  return stored;
}

using Parse = StoredPoints (*)(std::span<const std::uint8_t>);

constexpr std::array<std::pair<std::string_view, Parse>, 6> formats{{{".ply", ply_points},
                                                                     {".pcd", pcd_points},
                                                                     {".xyz", xyz_points},
                                                                     {".stl", stl_points},
                                                                     {".obj", obj_points},
                                                                     {".glb", glb_points}}};

/// Null where no such file can be read.
Parse parse_for(const fs::path& path) {
  const std::string extension = lower_case_extension(path);
  const auto* const found = std::find_if(formats.begin(), formats.end(), [&](const auto& format) {
    return format.first == extension;
  });
  return found == formats.end() ? nullptr : found->second;
}

bool is_finite(const StoredPoint& point) {
  return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z);
}

StoredCloud cloud_of(StoredPoints stored) {
  const bool organised = stored.organised != Size{};
  if (!organised) {
    std::erase_if(stored.points, [](const StoredPoint& point) { return !is_finite(point); });
  }
  const Size size = organised ? stored.organised : Size{static_cast<int>(stored.points.size()), 1};
  StoredCloud result{.cloud = Cloud(size), .uncertainty = {}, .organised = organised};
  if (stored.has_sigma) result.uncertainty.emplace(size);
  for (std::size_t i = 0; i < stored.points.size(); ++i) {
    const StoredPoint& point = stored.points[i];
    const auto put = [i](Image<float>& image, double value) {
      image.begin()[i] = static_cast<float>(value);
    };
    put(result.cloud.intensity, point.intensity);
    if (!is_finite(point)) continue;
    put(result.cloud.x, point.x);
    put(result.cloud.y, point.y);
    put(result.cloud.z, point.z);
    result.cloud.validity.begin()[i] = Validity::valid;
    if (!result.uncertainty) continue;
    put(result.uncertainty->coordinate, point.sigma_coordinate);
    put(result.uncertainty->x, point.sigma_x);
    put(result.uncertainty->y, point.sigma_y);
    put(result.uncertainty->z, point.sigma_z);
  }
  return result;
}

}  // namespace

bool is_cloud_file(const fs::path& path) {
  return parse_for(path) != nullptr;
}

StoredPoints read_points(const fs::path& path) {
  const Parse parse = parse_for(path);
  if (parse == nullptr) {
    throw Error(
        fmt::format("{}: no cloud or mesh that can be read has the ending '{}'; use .ply, "
                    ".pcd, .xyz, .stl, .obj or .glb",
                    path.string(), lower_case_extension(path)));
  }
  const std::vector<std::uint8_t> bytes = read_file(path);
  return naming(
      fmt::format("{} is not a good {} file", path.string(), lower_case_extension(path).substr(1)),
      [&] { return parse(bytes); });
}

StoredCloud read_cloud(const fs::path& path) {
  StoredCloud stored = cloud_of(read_points(path));
  if (point_count(stored.cloud) == 0) throw Error(fmt::format("{}: no point in it", path.string()));
  return stored;
}

}  // namespace slipstream
