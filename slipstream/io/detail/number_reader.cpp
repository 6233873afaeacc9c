#include <algorithm>
#include <array>
#include <bit>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"
#include "slipstream/io/detail/point_formats.h"

namespace slipstream {
namespace {

NumberType type_named(std::string_view name) {
  static constexpr std::array<std::string_view, 16> names{
      "char", "int8",  "uchar", "uint8",  "short", "int16",   "ushort", "uint16",
      "int",  "int32", "uint",  "uint32", "float", "float32", "double", "float64"};
  const auto* const found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw Error(fmt::format("'{}' is no type of PLY", name));
  return static_cast<NumberType>((found - names.begin()) / 2);
}

NumberFormat format_named(std::string_view name) {
  if (name == "ascii") return NumberFormat::ascii;
  if (name == "binary_little_endian") return NumberFormat::little_endian;
  if (name == "binary_big_endian") return NumberFormat::big_endian;
  throw Error(fmt::format("'{}' is no format of PLY", name));
}

}  // namespace

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
  if (const auto count = number_in<std::size_t>(text)) return *count;
  throw Error(fmt::format("'{}' is no number of elements", text.substr(0, 20)));
}

std::string_view NumberReader::line() {
  if (text_.empty()) throw Error("it ends within its header");
  const std::size_t end = std::min(text_.find('\n'), text_.size());
  std::string_view line = text_.substr(0, end);
  text_.remove_prefix(std::min(end + 1, text_.size()));
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

template <class Stored>
double NumberReader::binary_number() {
  if (text_.size() < sizeof(Stored)) throw Error("it is truncated");
  std::array<char, sizeof(Stored)> bytes;
  std::copy_n(text_.begin(), sizeof(Stored), bytes.begin());
  if (swapped_) std::reverse(bytes.begin(), bytes.end());
  text_.remove_prefix(sizeof(Stored));
  return static_cast<double>(std::bit_cast<Stored>(bytes));
}

double NumberReader::ascii_number() {
  const std::size_t start = text_.find_first_not_of(" \t\r\n");
  if (start == std::string_view::npos) throw Error("it is truncated");
  text_.remove_prefix(start);
  const std::string_view word = text_.substr(0, text_.find_first_of(" \t\r\n"));
  const auto number = number_in<double>(word);
  if (!number) throw Error(fmt::format("'{}' is not a number", word.substr(0, 20)));
  text_.remove_prefix(word.size());
  return *number;
}

double NumberReader::number(NumberType type) {
  if (ascii_) return ascii_number();
  using R = NumberReader;  // in the order of NumberType
  static constexpr std::array<double (R::*)(), 8> by_type{
      &R::binary_number<std::int8_t>,  &R::binary_number<std::uint8_t>,
      &R::binary_number<std::int16_t>, &R::binary_number<std::uint16_t>,
      &R::binary_number<std::int32_t>, &R::binary_number<std::uint32_t>,
      &R::binary_number<float>,        &R::binary_number<double>};
  return (this->*by_type[static_cast<std::size_t>(type)])();
}

void NumberReader::set_format(NumberFormat format) {
  constexpr bool native_is_little = std::endian::native == std::endian::little;
  ascii_ = format == NumberFormat::ascii;
  swapped_ = format == (native_is_little ? NumberFormat::big_endian : NumberFormat::little_endian);
}

std::vector<PlyElement> read_ply_header(NumberReader& reader) {
  if (reader.line() != "ply") throw Error("it does not begin with 'ply'");
  std::vector<PlyElement> elements;
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

}  // namespace slipstream
