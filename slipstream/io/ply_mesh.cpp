#include "slipstream/io/ply_mesh.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

Type type_named(std::string_view name) {
  static constexpr std::array<std::array<std::string_view, 2>, 8> names{{{"char", "int8"},
                                                                         {"uchar", "uint8"},
                                                                         {"short", "int16"},
                                                                         {"ushort", "uint16"},
                                                                         {"int", "int32"},
                                                                         {"uint", "uint32"},
                                                                         {"float", "float32"},
                                                                         {"double", "float64"}}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (name == names[i][0] || name == names[i][1]) return static_cast<Type>(i);
  }
  throw Error(fmt::format("'{}' is no type of PLY", name));
}

struct Property {
  std::string name;
  Type type = Type::float32;
  std::optional<Type> count_type;  ///< of a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

/// Takes words, lines and numbers off the front of the file, never past its end.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

  std::string_view line() {
    if (text_.empty()) throw Error("it ends within its header");
    const std::size_t end = std::min(text_.find('\n'), text_.size());
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  double number(Type type) {
    if (ascii_) return ascii_number();
    switch (type) {
      case Type::int8:
        return binary_number<std::int8_t>();
      case Type::uint8:
        return binary_number<std::uint8_t>();
      case Type::int16:
        return binary_number<std::int16_t>();
      case Type::uint16:
        return binary_number<std::uint16_t>();
      case Type::int32:
        return binary_number<std::int32_t>();
      case Type::uint32:
        return binary_number<std::uint32_t>();
      case Type::float32:
        return binary_number<float>();
      case Type::float64:
        return binary_number<double>();
    }
    return 0;
  }

  void set_format(std::string_view format) {
    ascii_ = format == "ascii";
    swapped_ = format == (std::endian::native == std::endian::little ? "binary_big_endian"
                                                                     : "binary_little_endian");
    if (!ascii_ && format != "binary_little_endian" && format != "binary_big_endian") {
      throw Error(fmt::format("'{}' is no format of PLY", format));
    }
  }

  /// Bytes not yet read: no element has more numbers than that.
  [[nodiscard]] std::size_t left() const { return text_.size(); }

 private:
  double ascii_number() {
    const std::size_t start = text_.find_first_not_of(" \t\r\n");
    if (start == std::string_view::npos) throw Error("it is truncated");
    text_.remove_prefix(start);
    const std::string_view word = text_.substr(0, text_.find_first_of(" \t\r\n"));
    double number = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (failure != std::errc() || end != word.data() + word.size()) {
      throw Error(fmt::format("'{}' is not a number", word.substr(0, 20)));
    }
    text_.remove_prefix(word.size());
    return number;
  }

  template <class Stored>
  double binary_number() {
    if (text_.size() < sizeof(Stored)) throw Error("it is truncated");
    std::array<char, sizeof(Stored)> bytes;
    std::copy_n(text_.begin(), sizeof(Stored), bytes.begin());
    if (swapped_) std::reverse(bytes.begin(), bytes.end());
    text_.remove_prefix(sizeof(Stored));
    return static_cast<double>(std::bit_cast<Stored>(bytes));
  }

  std::string_view text_;
  bool ascii_ = true;
  bool swapped_ = false;
};

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t start = line.find_first_not_of(" \t");
    if (start == std::string_view::npos) return words;
    line.remove_prefix(start);
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

std::size_t count_from(std::string_view text) {
  std::size_t count = 0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (failure != std::errc() || end != text.data() + text.size()) {
    throw Error(fmt::format("'{}' is no number of elements", text.substr(0, 20)));
  }
  return count;
}

std::vector<Element> read_header(Reader& reader) {
  if (reader.line() != "ply") throw Error("it does not begin with 'ply'");
  std::vector<Element> elements;
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
      throw Error(
          fmt::format("its header has a line that begins with '{}'", words[0].substr(0, 20)));
    }
  }
}

/// The numbers of one property: one, or as many as a list has.
std::vector<double> read_property(const Property& property, Reader& reader) {
  const double count = property.count_type ? reader.number(*property.count_type) : 1;
  if (!(count >= 0 && count <= static_cast<double>(reader.left()))) {
    throw Error(fmt::format("a list of {} numbers does not fit into it", count));
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    numbers.push_back(reader.number(property.type));
  }
  return numbers;
}

int index_from(double number) {
  const bool index = number >= 0 && number <= std::numeric_limits<int>::max();
  if (!index || number != std::floor(number)) {
    throw Error(fmt::format("{} is no index of a vertex", number));
  }
  return static_cast<int>(number);
}

void read_vertex(const Element& element, Reader& reader, Mesh& mesh) {
  Eigen::Vector3d vertex = Eigen::Vector3d::Zero();
  for (const Property& property : element.properties) {
    const std::vector<double> numbers = read_property(property, reader);
    if (numbers.size() != 1 || property.name.size() != 1) continue;
    const char axis = property.name[0];
    if (axis >= 'x' && axis <= 'z') vertex(axis - 'x') = numbers[0];
  }
  mesh.vertices.push_back(vertex);
}

void read_face(const Element& element, Reader& reader, Mesh& mesh) {
  for (const Property& property : element.properties) {
    const std::vector<double> corners = read_property(property, reader);
    if (property.name != "vertex_indices" && property.name != "vertex_index") continue;
    for (std::size_t i = 2; i < corners.size(); ++i) {
      mesh.triangles.push_back(
          {index_from(corners[0]), index_from(corners[i - 1]), index_from(corners[i])});
    }
  }
}

}  // namespace

Mesh ply_mesh(std::span<const std::uint8_t> bytes) {
  Reader reader(bytes);
  Mesh mesh;
  for (const Element& element : read_header(reader)) {
    if (element.properties.empty()) continue;
    for (std::size_t i = 0; i < element.count; ++i) {
      if (element.name == "vertex") {
        read_vertex(element, reader, mesh);
      } else {
        read_face(element, reader, mesh);
      }
    }
  }
  return mesh;
}

}  // namespace slipstream
