#include "slipstream/io/ply_elements.h"

#include <array>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream::ply {
namespace {

NumberType type_named(std::string_view name) {
  static constexpr std::array<std::array<std::string_view, 2>, 8> names{{{"char", "int8"},
                                                                         {"uchar", "uint8"},
                                                                         {"short", "int16"},
                                                                         {"ushort", "uint16"},
                                                                         {"int", "int32"},
                                                                         {"uint", "uint32"},
                                                                         {"float", "float32"},
                                                                         {"double", "float64"}}};
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (name == names[i][0] || name == names[i][1]) return static_cast<NumberType>(i);
  }
  throw Error(fmt::format("'{}' is no type of PLY", name));
}

NumberFormat format_named(std::string_view name) {
  if (name == "ascii") return NumberFormat::ascii;
  if (name == "binary_little_endian") return NumberFormat::little_endian;
  if (name == "binary_big_endian") return NumberFormat::big_endian;
  throw Error(fmt::format("'{}' is no format of PLY", name));
}

}  // namespace

std::vector<Element> read_header(NumberReader& reader) {
  if (reader.line() != "ply") throw Error("it does not begin with 'ply'");
  std::vector<Element> elements;
  while (true) {
    const std::vector<std::string_view> words = words_of(reader.line());
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") return elements;
    if (words[0] == "format" && words.size() == 3) {
      reader.set_format(format_named(words[1]));
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

std::vector<double> read_property(const Property& property, NumberReader& reader) {
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

}  // namespace slipstream::ply
