#include <map>

#include "slipstream/base/numbers.h"
#include "slipstream/base/throw_if-inl.h"
#include "slipstream/io/detail/point_formats.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

enum class NumberType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

NumberType type_named(std::string_view name) {
  static constexpr std::array<std::string_view, 16> names{
      "char", "int8",  "uchar", "uint8",  "short", "int16",   "ushort", "uint16",
      "int",  "int32", "uint",  "uint32", "float", "float32", "double", "float64"};
  const auto* const found = std::find(names.begin(), names.end(), name);
  throw_if(found == names.end(), "'{}' is not a PLY type", name);
  return static_cast<NumberType>((found - names.begin()) / 2);
}

/// Reads lines and numbers from the front of a file of points. Throws Error, without a file name,
/// if it is truncated.
class NumberReader {
 public:
  explicit NumberReader(std::span<const std::uint8_t> bytes)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

  /// The unread rest; no element can have more numbers than this has bytes.
  [[nodiscard]] std::string_view left() const { return text_; }

  /// Sets the format of the numbers that follow, by its PLY name; ASCII by default.
  void set_format(std::string_view name) {
    ascii_ = name == "ascii";
    big_endian_ = name == "binary_big_endian";
    throw_if(!ascii_ && !big_endian_ && name != "binary_little_endian", "'{}' is not a PLY format",
             name);
  }

  std::string_view line() {
    if (text_.empty()) throw Error("it ends within its header");
    const std::size_t end = std::min(text_.find('\n'), text_.size());
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  double number(NumberType type) {
    if (ascii_) return ascii_number();
    using R = NumberReader;  // in the order of NumberType
    static constexpr std::array<double (R::*)(), 8> by_type{
        &R::binary_number<std::int8_t>,  &R::binary_number<std::uint8_t>,
        &R::binary_number<std::int16_t>, &R::binary_number<std::uint16_t>,
        &R::binary_number<std::int32_t>, &R::binary_number<std::uint32_t>,
        &R::binary_number<float>,        &R::binary_number<double>};
    return (this->*by_type[static_cast<std::size_t>(type)])();
  }

 private:
  template <class Stored>
  double binary_number() {
    if (text_.size() < sizeof(Stored)) throw Error("it is truncated");
    const std::span bytes(reinterpret_cast<const std::uint8_t*>(text_.data()), sizeof(Stored));
    text_.remove_prefix(sizeof(Stored));
    return static_cast<double>(big_endian_ ? number_at<Stored, std::endian::big>(bytes, 0)
                                           : number_at<Stored>(bytes, 0));
  }

  double ascii_number() {
    const std::size_t start = text_.find_first_not_of(" \t\r\n");
    if (start == std::string_view::npos) throw Error("it is truncated");
    text_.remove_prefix(start);
    const std::string_view word = text_.substr(0, text_.find_first_of(" \t\r\n"));
    const auto number = number_in<double>(word);
    throw_if(!number, "'{}' is not a number", word.substr(0, 20));
    text_.remove_prefix(word.size());
    return *number;
  }

  std::string_view text_;
  bool ascii_ = true;
  bool big_endian_ = false;
};

/// Splits at blanks.
std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t start = line.find_first_not_of(" \t");
    if (start == std::string_view::npos) return words;
    line.remove_prefix(start);
    words.push_back(line.substr(0, line.find_first_of(" \t")));
    line.remove_prefix(words.back().size());
  }
}

/// Parses a count. Throws Error for any other word.
std::size_t count_from(std::string_view text) {
  if (const auto count = number_in<std::size_t>(text)) return *count;
  throw Error(fmt::format("'{}' is not a number of elements", text.substr(0, 20)));
}

/// A property of a PLY element: a number or a list of numbers.
struct PlyProperty {
  std::string name;
  NumberType type = NumberType::float32;
  std::optional<NumberType> count_type{};  ///< of a list
};

/// An element of a PLY file, such as "vertex".
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties{};
};

/// The elements of a PLY file, in order. Throws Error if it is not a PLY file.
std::vector<PlyElement> read_ply_header(NumberReader& reader) {
  if (reader.line() != "ply") throw Error("it does not begin with 'ply'");
  std::vector<PlyElement> elements;
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

/// The numbers of one property: one, or a list.
std::vector<double> read_property(const PlyProperty& property, NumberReader& reader) {
  const double count = property.count_type ? reader.number(*property.count_type) : 1;
  throw_if(!(count >= 0 && count <= static_cast<double>(reader.left().size())),
           "a list of {} numbers is longer than the file", count);
  std::vector<double> numbers;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    numbers.push_back(reader.number(property.type));
  }
  return numbers;
}

/// The member of StoredPoint to which a column adds, and its weight.
struct Target {
  double StoredPoint::*field = nullptr;
  double share = 1;
};

Target target_of(const PlyProperty& property) {
  // The weights of the luminance of ITU-R BT.601.
  static const std::map<std::string, Target> targets{
      {"x", {&StoredPoint::x}},
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
      {"sigma_z", {&StoredPoint::sigma_z}}};
  const auto found = targets.find(property.name);
  return found == targets.end() || property.count_type ? Target{} : found->second;
}

/// The targets of an element's properties; an intensity overrides colours.
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

/// -1 if not an index.
int index_from(double number) {
  const bool index = number >= 0 && number <= std::numeric_limits<int>::max();
  return index && number == std::floor(number) ? static_cast<int>(number) : -1;
}

/// Reads an element; stores vertices and faces, skips others.
void read_element(const PlyElement& element, NumberReader& reader, StoredPoints& stored) {
  if (element.properties.empty()) return;
  const std::vector<Target> targets = targets_of(element);
  const bool vertices = element.name == "vertex";
  const auto lacks = [&](double StoredPoint::*field) {
    return std::none_of(targets.begin(), targets.end(),
                        [field](const Target& target) { return target.field == field; });
  };
  throw_if(vertices && (lacks(&StoredPoint::x) || lacks(&StoredPoint::y) || lacks(&StoredPoint::z)),
           "its points have no x, y and z");
  for (std::size_t i = 0; i < element.count; ++i) {
    StoredPoint point;
    for (std::size_t k = 0; k < targets.size(); ++k) {
      const std::vector<double> numbers = read_property(element.properties[k], reader);
      if (targets[k].field != nullptr) point.*targets[k].field += targets[k].share * numbers[0];
      const std::string& name = element.properties[k].name;
      const bool is_face = name == "vertex_indices" || name == "vertex_index";
      for (std::size_t n = 2; is_face && n < numbers.size(); ++n) {  // triangle fan
        stored.triangles.push_back(
            {index_from(numbers[0]), index_from(numbers[n - 1]), index_from(numbers[n])});
      }
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

/// The words of each line of a PCD header, by its first word.
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
    throw_if(header[key].empty(), "its header has no {}", key);
  }
  return header;
}

/// Supports only fields of one 32-bit float each, as by write_cloud and most other writers.
StoredPoints pcd_points(std::span<const std::uint8_t> bytes) {
  NumberReader reader(bytes);
  const auto header = pcd_header(reader);
  const auto all = [&](const char* key, std::string_view wanted) {
    const auto& words = header.at(key);
    return std::all_of(words.begin(), words.end(), [&](auto word) { return word == wanted; });
  };
  throw_if(!all("SIZE", "4") || !all("TYPE", "F") || !all("COUNT", "1"),
           "its fields are not one 32-bit float each");
  throw_if(!all("DATA", "binary") && !all("DATA", "ascii"), "its DATA is neither ascii nor binary");
  if (all("DATA", "binary")) reader.set_format("binary_little_endian");
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

/// The columns of a text by write_cloud, by their number.
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
    throw_if(words_of(lines.line()).size() != columns,
             "line {}: expected {} numbers, as in the first line", element.count + 1, columns);
  }
  StoredPoints stored;
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
  const bool organised = stored.organised != Size{};
  if (!organised) {
    std::erase_if(stored.points, [](const StoredPoint& point) { return !is_finite(point); });
  }
  const Size size = organised ? stored.organised : Size{static_cast<int>(stored.points.size()), 1};
  StoredCloud result{.cloud = Cloud(size), .uncertainty = {}, .organised = organised};
  Cloud& cloud = result.cloud;
  std::vector<std::pair<Image<float>*, double StoredPoint::*>> columns{
      {&cloud.x, &StoredPoint::x}, {&cloud.y, &StoredPoint::y}, {&cloud.z, &StoredPoint::z}};
  if (stored.has_sigma) {
    Uncertainty& sigma = result.uncertainty.emplace(size);
    columns.insert(columns.end(), {{&sigma.coordinate, &StoredPoint::sigma_coordinate},
                                   {&sigma.x, &StoredPoint::sigma_x},
                                   {&sigma.y, &StoredPoint::sigma_y},
                                   {&sigma.z, &StoredPoint::sigma_z}});
  }
  for (std::size_t i = 0; i < stored.points.size(); ++i) {
    const StoredPoint& point = stored.points[i];
    cloud.intensity.begin()[i] = static_cast<float>(point.intensity);
    if (!is_finite(point)) continue;
    cloud.validity.begin()[i] = Validity::valid;
    for (const auto& [image, field] : columns) {
      image->begin()[i] = static_cast<float>(point.*field);
    }
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
