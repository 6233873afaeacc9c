#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/point_elements.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

NumberType type_named(std::string_view name) {
  static constexpr std::array<std::string_view, 16> names{
      "char", "int8",  "uchar", "uint8",  "short", "int16",   "ushort", "uint16",
      "int",  "int32", "uint",  "uint32", "float", "float32", "double", "float64"};

  const auto* const found = std::find(names.begin(), names.end(), name);
  throw_if(found == names.end(), "'{}' is not a PLY type", name);

  // Each type has two names, in the order of NumberType.
  return static_cast<NumberType>((found - names.begin()) / 2);
}

/// The elements of a PLY file, in order. Throws Error if it is not a PLY file.
std::vector<PointElement> read_ply_header(NumberReader& reader) {
  if (reader.line() != "ply") throw Error("it does not begin with 'ply'");

  std::vector<PointElement> elements;
  while (true) {
    const std::vector<std::string_view> words = words_of(reader.line());
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") return elements;

    if (words[0] == "format" && words.size() == 3) {
      reader.set_format(words[1]);
    } else if (words[0] == "element" && words.size() == 3) {
      elements.push_back({std::string(words[1]), count_from(words[2]), {}});
    } else if (words[0] == "property" && words.size() == 3 && !elements.empty()) {
      elements.back().properties.push_back({std::string(words[2]), type_named(words[1]), {}});
    } else if (words[0] == "property" && words.size() == 5 && words[1] == "list" &&
               !elements.empty()) {
      elements.back().properties.push_back(
          {std::string(words[4]), type_named(words[3]), type_named(words[2])});
    } else {
      throw Error(fmt::format("its header has an unknown line '{}'", words[0].substr(0, 20)));
    }
  }
}

StoredPoints ply_points(std::span<const std::uint8_t> bytes) {
  NumberReader reader(bytes);
  StoredPoints stored;

  for (const PointElement& element : read_ply_header(reader)) read_element(element, reader, stored);
  return stored;
}

/// The words of each line of a PCD header, by its first word.
using PcdHeader = std::map<std::string, std::vector<std::string_view>, std::less<>>;

PcdHeader pcd_header(NumberReader& reader) {
  PcdHeader header;

  // DATA ends the header.
  while (!header.contains("DATA")) {
    std::vector<std::string_view> words = words_of(reader.line());
    if (words.empty() || words[0].starts_with('#')) continue;

    const std::string key(words[0]);
    words.erase(words.begin());
    header[key] = std::move(words);
  }

  if (!header.contains("COUNT")) header["COUNT"].assign(header["FIELDS"].size(), "1");

  for (const char* key : {"FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "DATA"}) {
    throw_if(header[key].empty(), "its header has no {}", key);
  }

  for (const char* key : {"SIZE", "TYPE", "COUNT"}) {
    throw_if(header[key].size() != header["FIELDS"].size(), "its header has {} FIELDS, but {} {}",
             header["FIELDS"].size(), header[key].size(), key);
  }

  return header;
}

/// `name`, `type`, `size`, `count`: a word each of FIELDS, TYPE, SIZE and COUNT.
PointProperty pcd_field(std::string_view name, std::string_view type, std::string_view size,
                        std::string_view count, bool binary) {
  using T = NumberType;
  static const std::map<std::string, NumberType> types{
      {"I1", T::int8},    {"U1", T::uint8},  {"I2", T::int16}, {"U2", T::uint16},
      {"I4", T::int32},   {"U4", T::uint32}, {"I8", T::int64}, {"U8", T::uint64},
      {"F4", T::float32}, {"F8", T::float64}};

  const auto found = types.find(fmt::format("{}{}", type, size));
  throw_if(found == types.end(), "field {}: '{} {}' is not a type", name.substr(0, 20),
           type.substr(0, 20), size.substr(0, 20));

  // The bits of a float that is not a number may change when it is converted.
  const bool packed = binary && size == "4" && (name == "rgb" || name == "rgba");

  return {std::string(name), packed ? T::uint32 : found->second, std::nullopt, count_from(count)};
}

StoredPoints pcd_points(std::span<const std::uint8_t> bytes) {
  // 1. The format of the numbers.
  NumberReader reader(bytes);
  const PcdHeader header = pcd_header(reader);

  const std::string_view data = header.at("DATA")[0];
  throw_if(data != "binary" && data != "ascii", "its DATA is neither ascii nor binary");
  const bool binary = data == "binary";
  if (binary) reader.set_format("binary_little_endian");

  // 2. The fields, as properties of one element.
  PointElement element{.name = "vertex", .properties = {}};
  for (std::size_t k = 0; k < header.at("FIELDS").size(); ++k) {
    element.properties.push_back(pcd_field(header.at("FIELDS")[k], header.at("TYPE")[k],
                                           header.at("SIZE")[k], header.at("COUNT")[k], binary));
  }

  // 3. The points, as a picture if there are several rows.
  const std::size_t width = count_from(header.at("WIDTH")[0]);
  const std::size_t height = count_from(header.at("HEIGHT")[0]);
  if (std::max(width, height) > reader.left().size()) throw Error("it is truncated");
  element.count = width * height;

  StoredPoints stored;
  if (height > 1) stored.organised = {static_cast<int>(width), static_cast<int>(height)};
  read_element(element, reader, stored);

  return stored;
}

using Parse = StoredPoints (*)(std::span<const std::uint8_t>);

/// Null if unsupported.
Parse parse_for(const fs::path& path) {
  static const std::map<std::string, Parse> formats{{".ply", ply_points}, {".pcd", pcd_points},
                                                    {".xyz", xyz_points}, {".stl", stl_points},
                                                    {".obj", obj_points}, {".glb", glb_points}};

  const auto found = formats.find(lower_case_extension(path));
  return found == formats.end() ? nullptr : found->second;
}

bool is_finite(const StoredPoint& point) {
  return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z);
}

StoredCloud cloud_of(StoredPoints stored) {
  // 1. The size: the picture's, where invalid pixels stay, or one row of points.
  const bool organised = stored.organised != Size{};
  if (!organised) {
    std::erase_if(stored.points, [](const StoredPoint& point) { return !is_finite(point); });
  }

  const Size size = organised ? stored.organised : Size{static_cast<int>(stored.points.size()), 1};
  StoredCloud result{.cloud = Cloud(size), .uncertainty = {}, .organised = organised};
  Cloud& cloud = result.cloud;

  // 2. Which column of the file fills which image.
  std::vector<std::pair<Image<float>*, double StoredPoint::*>> columns{
      {&cloud.x, &StoredPoint::x}, {&cloud.y, &StoredPoint::y}, {&cloud.z, &StoredPoint::z}};

  if (stored.has_sigma) {
    Uncertainty& sigma = result.uncertainty.emplace(size);
    columns.insert(columns.end(), {{&sigma.coordinate, &StoredPoint::sigma_coordinate},
                                   {&sigma.x, &StoredPoint::sigma_x},
                                   {&sigma.y, &StoredPoint::sigma_y},
                                   {&sigma.z, &StoredPoint::sigma_z}});
  }

  // 3. The points.
  for (std::size_t i = 0; i < stored.points.size(); ++i) {
    const StoredPoint& point = stored.points[i];
    cloud.intensity.begin()[i] = static_cast<float>(point.intensity);
    if (!is_finite(point)) continue;

    cloud.validity.begin()[i] = Validity::valid;
    for (const auto& [image, field] : columns) image->begin()[i] = static_cast<float>(point.*field);
  }

  return result;
}

}  // namespace

bool is_cloud_file(const fs::path& path) {
  return parse_for(path) != nullptr;
}

StoredPoints read_points(const fs::path& path) {
  const Parse parse = parse_for(path);
  throw_if(parse == nullptr,
           "{}: cannot read clouds or meshes with the ending '{}'; use .ply, .pcd, .xyz, .stl, "
           ".obj or .glb",
           path.string(), lower_case_extension(path));

  const std::vector<std::uint8_t> bytes = read_file(path);
  return naming(
      fmt::format("{} is not a valid {} file", path.string(), lower_case_extension(path).substr(1)),
      [&] { return parse(bytes); });
}

StoredCloud read_cloud(const fs::path& path) {
  StoredCloud stored = cloud_of(read_points(path));
  throw_if(point_count(stored.cloud) == 0, "{}: has no points", path.string());
  return stored;
}

}  // namespace slipstream
