#include "slipstream/cloud_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/ranges.h>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/frame_title.h"
#include "io/glb_file.h"
#include "io/mesh_file.h"
#include "io/point_elements.h"
#include "io/xyz_points.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// A column after x y z intensity, with its names in PLY and PCD.
struct Extra {
  const char* ply_name;
  const char* pcd_name;
  const Image<float>& values;
};

constexpr const char* systematic_name = "systematic_z";

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
    if (!sigma->z_systematic.empty()) {
      all.push_back({systematic_name, systematic_name, sigma->z_systematic});
    }
  }

  return all;
}

/// The remarks as comment lines of a header.
std::string comments_of(const std::vector<std::string>& remarks, std::string_view mark) {
  std::string lines;
  for (std::string remark : remarks) {
    // A line break would end the comment.
    std::replace_if(
        remark.begin(), remark.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    lines += fmt::format("{} {}\n", mark, remark);
  }
  return lines;
}

template <class Visit>
void for_each_point(const Cloud& cloud, const Visit& visit) {
  static_assert(sizeof(Validity) == 1);

  for (int row = 0; row < cloud.size().height; ++row) {
    const Validity* const first = cloud.validity.row(row);
    const Validity* const end = first + cloud.size().width;

    for (const Validity* pixel = first; pixel != end; ++pixel) {
      if (*pixel != Validity::valid) {
        // Most pixels of a picture lie beside the object.
        const void* const next = std::memchr(pixel, static_cast<int>(Validity::valid),
                                             static_cast<std::size_t>(end - pixel));
        if (next == nullptr) break;
        pixel = static_cast<const Validity*>(next);
      }

      visit(static_cast<int>(pixel - first), row);
    }
  }
}

std::string ply_file(const Cloud& cloud, const std::vector<Extra>& extras,
                     const std::vector<std::string>& remarks) {
  const std::size_t points = point_count(cloud);

  std::string file = fmt::format(
      "ply\nformat binary_little_endian 1.0\n{}{}"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "{}",
      frame_comments(cloud.frame.get(), "comment"), comments_of(remarks, "comment"), points,
      ply_intensity);

  for (const Extra& extra : extras) file += fmt::format("property float {}\n", extra.ply_name);
  file += "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";

  // Bytes of a point: position in float, intensity in double and three colours.
  constexpr std::size_t place_intensity_colour = 12 + 8 + 3;
  const std::size_t header = file.size();
  file.resize(header + points * (place_intensity_colour + 4 * extras.size()));

  char* to = file.data() + header;
  const auto put = [&to](const auto& number) {
    std::memcpy(to, &number, sizeof number);
    to += sizeof number;
  };

  for_each_point(cloud, [&](int column, int row) {
    const float intensity = cloud.intensity(column, row);
    // In the order of the header.
    for (const Image<float>* image : {&cloud.x, &cloud.y, &cloud.z}) put((*image)(column, row));
    put(double{intensity});
    for (const Extra& extra : extras) put(extra.values(column, row));

    const Colour colour = colour_at(cloud, column, row);
    put(std::array{colour.red, colour.green, colour.blue});
  });

  return file;
}

std::string pcd_file(const Cloud& cloud, const std::vector<Extra>& extras,
                     const std::vector<std::string>& remarks) {
  // All columns are 32-bit float.
  std::vector<const Image<float>*> columns{&cloud.x, &cloud.y, &cloud.z, &cloud.intensity};
  std::string fields = "x y z intensity";

  for (const Extra& extra : extras) {
    columns.push_back(&extra.values);
    fields += fmt::format(" {}", extra.pcd_name);
  }

  // A colour is the bits of a float, as PCL has it.
  Image<float> packed;
  if (!cloud.colour.empty()) {
    packed = Image<float>(cloud.size(), uninitialised);
    std::ranges::transform(cloud.colour, packed.begin(), packed_colour);
    columns.push_back(&packed);
    fields += " rgb";
  }

  const auto of_each = [&](const char* word) {
    return fmt::format("{}", fmt::join(std::vector(columns.size(), word), " "));
  };

  std::string file = fmt::format(
      "# .PCD v0.7 - {}\n{}VERSION 0.7\nFIELDS {}\nSIZE {}\nTYPE {}\n"
      "COUNT {}\nWIDTH {}\nHEIGHT {}\nVIEWPOINT {}\nPOINTS {}\nDATA binary\n",
      frame_title(cloud.frame.get()), comments_of(remarks, "#"), fields, of_each("4"), of_each("F"),
      of_each("1"), cloud.size().width, cloud.size().height, viewpoint_text(cloud.frame.get()),
      cloud.z.pixel_count());

  for (std::size_t pixel = 0; pixel < cloud.z.pixel_count(); ++pixel) {
    for (const Image<float>* column : columns) append_numbers(file, column->begin()[pixel]);
  }

  return file;
}

std::string xyz_file(const Cloud& cloud, const std::vector<Extra>& extras) {
  std::string file;
  for_each_point(cloud, [&](int column, int row) {
    fmt::format_to(std::back_inserter(file), "{:.6f} {:.6f} {:.6f} {:.3f}", cloud.x(column, row),
                   cloud.y(column, row), cloud.z(column, row), cloud.intensity(column, row));

    for (const Extra& extra : extras) {
      // Readers tell the columns by their number; other programs write files with one more.
      if (std::string_view(extra.ply_name) == systematic_name) continue;
      fmt::format_to(std::back_inserter(file), " {:.6g}", extra.values(column, row));
    }

    file += '\n';
  });
  return file;
}

NumberType type_named(std::string_view name) {
  static constexpr std::array<std::string_view, 16> names{
      "char", "int8",  "uchar", "uint8",  "short", "int16",   "ushort", "uint16",
      "int",  "int32", "uint",  "uint32", "float", "float32", "double", "float64"};

  const auto* const found = std::find(names.begin(), names.end(), name);
  throw_if(found == names.end(), "'{}' is not a PLY type", name);

  // Each type has two names, in the order of NumberType.
  return static_cast<NumberType>((found - names.begin()) / 2);
}

/// The elements of a PLY file, in order; comments go to `title`. Throws Error if it is not a PLY
/// file.
std::vector<PointElement> read_ply_header(NumberReader& reader, FrameTitle& title) {
  if (reader.line() != "ply") throw Error("it does not begin with 'ply'");

  std::vector<PointElement> elements;
  while (true) {
    const std::string_view line = reader.line();
    const std::vector<std::string_view> words = words_of(line);
    constexpr std::string_view comment = "comment ";
    if (line.starts_with(comment)) title.read(line.substr(comment.size()));
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
  FrameTitle title;

  for (const PointElement& element : read_ply_header(reader, title)) {
    read_element(element, reader, stored);
  }
  stored.frame = title.frame();
  return stored;
}

/// The words of each line of a PCD header, by its first word.
using PcdHeader = std::map<std::string, std::vector<std::string_view>, std::less<>>;

/// Reads it; lines about the frame also go to `title`.
PcdHeader pcd_header(NumberReader& reader, FrameTitle& title) {
  PcdHeader header;

  // DATA ends the header.
  while (!header.contains("DATA")) {
    const std::string_view line = reader.line();
    title.read(line);
    std::vector<std::string_view> words = words_of(line);
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
  FrameTitle title;
  const PcdHeader header = pcd_header(reader, title);

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
  stored.frame = title.frame();

  return stored;
}

using Parse = StoredPoints (*)(std::span<const std::uint8_t>);

/// Null if unsupported.
Parse parse_for(const fs::path& path) {
  static const std::map<std::string, Parse> formats{
      {".ply", ply_points}, {".pcd", pcd_points}, {".xyz", xyz_points}, {".asc", xyz_points},
      {".txt", xyz_points}, {".csv", xyz_points}, {".pts", pts_points}, {".stl", stl_points},
      {".obj", obj_points}, {".glb", glb_points}};

  const auto found = formats.find(lower_case_extension(path));
  return found == formats.end() ? nullptr : found->second;
}

/// Also once rounded to 32 bits.
bool is_finite(const StoredPoint& point) {
  const auto is_number = [](double value) { return std::isfinite(static_cast<float>(value)); };
  return is_number(point.x) && is_number(point.y) && is_number(point.z);
}

Colour colour_of(const StoredPoint& point) {
  const auto& [red, green, blue] = point.colour;
  return {grey_level(red), grey_level(green), grey_level(blue)};
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
  cloud.frame = stored.frame;

  // 2. Which column of the file fills which image.
  std::vector<std::pair<Image<float>*, double StoredPoint::*>> columns{
      {&cloud.x, &StoredPoint::x}, {&cloud.y, &StoredPoint::y}, {&cloud.z, &StoredPoint::z}};

  if (stored.has_sigma) {
    Uncertainty& sigma = result.uncertainty.emplace(size);
    columns.insert(columns.end(), {{&sigma.coordinate, &StoredPoint::sigma_coordinate},
                                   {&sigma.x, &StoredPoint::sigma_x},
                                   {&sigma.y, &StoredPoint::sigma_y},
                                   {&sigma.z, &StoredPoint::sigma_z}});
    if (stored.has_systematic) {
      sigma.z_systematic = Image<float>(size, std::numeric_limits<float>::quiet_NaN());
      columns.emplace_back(&sigma.z_systematic, &StoredPoint::systematic_z);
    }
  }

  if (stored.has_colour) cloud.colour = Image<Colour>(size);

  // 3. The points.
  for (std::size_t i = 0; i < stored.points.size(); ++i) {
    const StoredPoint& point = stored.points[i];
    cloud.intensity.begin()[i] = static_cast<float>(point.intensity);
    if (stored.has_colour) cloud.colour.begin()[i] = colour_of(point);
    if (!is_finite(point)) continue;

    cloud.validity.begin()[i] = Validity::valid;
    for (const auto& [image, field] : columns) {
      const auto value = static_cast<float>(point.*field);
      image->begin()[i] = value;
      result.rounding = std::max(result.rounding, std::abs(value - point.*field));
    }
  }

  return result;
}

/// The bytes of copies of the cloud and its extras in the frame that the extras ask for.
std::string moved_bytes(const std::string& ending, Cloud cloud, const CloudExtras& extras) {
  std::optional<Normals> normals;
  if (extras.normals != nullptr) normals = *extras.normals;
  std::optional<Uncertainty> uncertainty;
  if (extras.uncertainty != nullptr) uncertainty = *extras.uncertainty;

  const FramePose motion = pose_from_frame(*extras.frame, frame_name(cloud));
  if (normals) move_to_frame(*normals, motion);
  move_to_frame(cloud, motion, uncertainty ? &*uncertainty : nullptr);

  return cloud_bytes(ending, cloud,
                     {.normals = normals ? &*normals : nullptr,
                      .uncertainty = uncertainty ? &*uncertainty : nullptr,
                      .remarks = extras.remarks});
}

}  // namespace

void require_cloud_ending(const fs::path& path) {
  if (path == standard_output) return;

  const std::string ending = lower_case_extension(path);
  throw_if(
      ending == ".stl" || ending == ".obj" || ending == ".glb",
      "{0}: no cloud format has the ending '{1}'; use .ply, .pcd, .xyz, or for a mesh of a scan "
      "`reconstruct()` `mesh {0}`",
      path.string(), ending);
  require_ending(path, "cloud format", {".ply", ".pcd", ".xyz"});
}

std::string cloud_bytes(const std::string& ending, const Cloud& cloud, const CloudExtras& extras) {
  require_cloud_ending("cloud" + ending);
  if (extras.frame) return moved_bytes(ending, cloud, extras);

  const std::string kind = lower_case_extension("cloud" + ending);
  const std::vector<Extra> columns = extras_of(extras);
  if (kind == ".ply") return ply_file(cloud, columns, extras.remarks);
  if (kind == ".pcd") return pcd_file(cloud, columns, extras.remarks);
  return xyz_file(cloud, columns);
}

void write_cloud(const fs::path& path, const Cloud& cloud, const CloudExtras& extras) {
  require_cloud_ending(path);

  const std::string ending = path == standard_output ? ".ply" : lower_case_extension(path);
  write_file(path, cloud_bytes(ending, cloud, extras));
}

bool is_cloud_file(const fs::path& path) {
  return parse_for(path) != nullptr;
}

StoredPoints read_points(const fs::path& path) {
  const Parse parse = parse_for(path);
  throw_if(parse == nullptr,
           "{}: cannot read clouds or meshes with the ending '{}'; use .ply, .pcd, .xyz, "
           ".asc, .txt, .csv, .pts, .stl, .obj or .glb",
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
