#include "slipstream/io/ply_elements.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream::ply {
namespace {

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

}  // namespace

std::string_view Reader::line() {
  if (text_.empty()) throw Error("it ends within its header");
  const std::size_t end = std::min(text_.find('\n'), text_.size());
  std::string_view line = text_.substr(0, end);
  text_.remove_prefix(std::min(end + 1, text_.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

template <class Stored>
double Reader::binary_number() {
  if (text_.size() < sizeof(Stored)) throw Error("it is truncated");
  std::array<char, sizeof(Stored)> bytes;
  std::copy_n(text_.begin(), sizeof(Stored), bytes.begin());
  if (swapped_) std::reverse(bytes.begin(), bytes.end());
  text_.remove_prefix(sizeof(Stored));
  return static_cast<double>(std::bit_cast<Stored>(bytes));
}

double Reader::ascii_number() {
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

double Reader::number(Type type) {
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

void Reader::set_format(std::string_view format) {
  ascii_ = format == "ascii";
  swapped_ = format == (std::endian::native == std::endian::little ? "binary_big_endian"
                                                                   : "binary_little_endian");
  if (!ascii_ && format != "binary_little_endian" && format != "binary_big_endian") {
    throw Error(fmt::format("'{}' is no format of PLY", format));
  }
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

}  // namespace slipstream::ply
