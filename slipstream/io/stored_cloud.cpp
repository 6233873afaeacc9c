#include "slipstream/io/stored_cloud.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/number_reader.h"
#include "slipstream/io/ply_elements.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

struct StoredPoint {
  double x = 0, y = 0, z = 0, intensity = 0;
  double sigma_coordinate = 0, sigma_x = 0, sigma_y = 0, sigma_z = 0;
};

/// What a file says, before it is a cloud.
struct StoredPoints {
  std::vector<StoredPoint> points{};
  bool has_sigma = false;
  Size organised{};  ///< as so many columns and rows; 0: not
};

/// Where a column of that name goes, and how much of it.
struct Target {
  double StoredPoint::*field = nullptr;
  double share = 1;
};

Target target_of(const ply::Property& property) {
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
std::vector<Target> targets_of(const ply::Element& element) {
  std::vector<Target> targets;
  bool has_intensity = false;
  for (const ply::Property& property : element.properties) {
    targets.push_back(target_of(property));
    const Target& target = targets.back();
    has_intensity |= target.field == &StoredPoint::intensity && target.share == 1;
  }
  for (Target& target : targets) {
    if (has_intensity && target.share != 1) target = {};
  }
  return targets;
}

/// Reads past an element; keeps its points where it is of vertices.
void read_element(const ply::Element& element, NumberReader& reader, StoredPoints& stored) {
  if (element.properties.empty()) return;
  const std::vector<Target> targets = targets_of(element);
  const bool vertices = element.name == "vertex";
  for (std::size_t i = 0; i < element.count; ++i) {
    StoredPoint point;
    for (std::size_t k = 0; k < targets.size(); ++k) {
      const std::vector<double> numbers = ply::read_property(element.properties[k], reader);
      if (targets[k].field != nullptr) point.*targets[k].field += targets[k].share * numbers[0];
    }
    if (vertices) stored.points.push_back(point);
  }
  stored.has_sigma |= vertices && std::any_of(targets.begin(), targets.end(), [](const auto& t) {
                        return t.field == &StoredPoint::sigma_z;
                      });
}

StoredPoints ply_points(NumberReader reader) {
  StoredPoints stored;
  for (const ply::Element& element : ply::read_header(reader)) {
    read_element(element, reader, stored);
  }
  return stored;
}

/// A PCD header's type "F" of size "4", and so on.
NumberType pcd_type(std::string_view type, std::string_view size) {
  static constexpr std::array<std::pair<std::string_view, NumberType>, 8> types{
      {{"I1", NumberType::int8},
       {"U1", NumberType::uint8},
       {"I2", NumberType::int16},
       {"U2", NumberType::uint16},
       {"I4", NumberType::int32},
       {"U4", NumberType::uint32},
       {"F4", NumberType::float32},
       {"F8", NumberType::float64}}};
  const std::string name = std::string(type) + std::string(size);
  for (const auto& [known, number] : types) {
    if (name == known) return number;
  }
  throw Error(fmt::format("'{}' is no type of PCD", name.substr(0, 20)));
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
  for (const char* key : {"FIELDS", "SIZE", "TYPE", "WIDTH", "HEIGHT", "DATA"}) {
    if (header[key].empty()) throw Error(fmt::format("its header has no {}", key));
  }
  return header;
}

StoredPoints pcd_points(NumberReader reader) {
  auto header = pcd_header(reader);
  const auto& fields = header["FIELDS"];
  auto& counts = header["COUNT"];
  counts.resize(fields.size(), "1");
  if (header["SIZE"].size() != fields.size() || header["TYPE"].size() != fields.size()) {
    throw Error("its FIELDS, SIZE and TYPE are not as many");
  }
  ply::Element element{.name = "vertex", .properties = {}};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const ply::Property property{std::string(fields[i]),
                                 pcd_type(header["TYPE"][i], header["SIZE"][i]), std::nullopt};
    const std::size_t count = count_from(counts[i]);
    if (count > reader.left().size()) throw Error("it is truncated");
    element.properties.insert(element.properties.end(), count, property);
  }
  const std::size_t width = count_from(header["WIDTH"][0]),
                    height = count_from(header["HEIGHT"][0]);
  if (width > reader.left().size() || height > reader.left().size()) throw Error("it is truncated");
  element.count = width * height;
  if (header["DATA"][0] == "binary") {
    reader.set_format(NumberFormat::little_endian);
  } else if (header["DATA"][0] != "ascii") {
    throw Error(fmt::format("its DATA are '{}'; ascii and binary can be read",
                            header["DATA"][0].substr(0, 20)));
  }
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

StoredPoints xyz_points(NumberReader reader) {
  NumberReader lines = reader;
  const std::size_t columns = lines.left().empty() ? 0 : words_of(lines.line()).size();
  ply::Element element{.name = "vertex", .count = 1, .properties = {}};
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

StoredPoints parsed(const std::vector<std::uint8_t>& bytes, const std::string& extension) {
  if (extension == ".ply") return ply_points(NumberReader(bytes));
  if (extension == ".pcd") return pcd_points(NumberReader(bytes));
  return xyz_points(NumberReader(bytes));
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

StoredCloud read_cloud(const fs::path& path) {
  const std::string extension = lower_case_extension(path);
  if (extension != ".ply" && extension != ".pcd" && extension != ".xyz") {
    throw Error(
        fmt::format("{}: no cloud that can be read has the ending '{}'; use .ply, .pcd or "
                    ".xyz",
                    path.string(), extension));
  }
  const std::vector<std::uint8_t> bytes = read_file(path);
  StoredCloud stored;
  try {
    stored = cloud_of(parsed(bytes, extension));
  } catch (const Error& error) {
    throw Error(
        fmt::format("{} is not a good {} file: {}", path.string(), extension, error.what()));
  }
  if (point_count(stored.cloud) == 0) throw Error(fmt::format("{}: no point in it", path.string()));
  return stored;
}

}  // namespace slipstream
