#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "slipstream/cloud_file.h"

// Elements of numbers in files of points, mm, as in PLY, PCD and XYZ. Functions throw Error,
// without a file name, if the data are malformed or truncated.
namespace slipstream {

/// Whether red, green and blue differ in some point.
bool any_colour(const std::vector<StoredPoint>& points);

/// Luminance of red, green and blue by ITU-R BT.601, in their unit.
double luminance(double red, double green, double blue);

/// The bits 0, red, green and blue, from the highest, as a float: the convention of PCL and ROS.
inline float packed_colour(Colour colour) {
  return std::bit_cast<float>(std::uint32_t{colour.red} << 16U | std::uint32_t{colour.green} << 8U |
                              colour.blue);
}

/// A property by the name that slipstream gives it: "R" and "red" are red.
std::string usual_name(std::string name);

/// PLY's number types in its order, then those that only PCD has.
enum class NumberType {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  float32,
  float64,
  int64,
  uint64
};

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

    std::string_view line = take_until(text_, '\n');
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  double number(NumberType type) {
    if (ascii_) return ascii_number();

    using R = NumberReader;  // in the order of NumberType
    static constexpr std::array<double (R::*)(), 10> by_type{
        &R::binary_number<std::int8_t>,  &R::binary_number<std::uint8_t>,
        &R::binary_number<std::int16_t>, &R::binary_number<std::uint16_t>,
        &R::binary_number<std::int32_t>, &R::binary_number<std::uint32_t>,
        &R::binary_number<float>,        &R::binary_number<double>,
        &R::binary_number<std::int64_t>, &R::binary_number<std::uint64_t>};

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

/// Splits at blanks, or other separators.
std::vector<std::string_view> words_of(std::string_view line, const char* separators = " \t");

/// Parses a count. Throws Error for any other word.
std::size_t count_from(std::string_view text);

/// A property of an element: a number, `count` numbers, or a list of numbers.
struct PointProperty {
  std::string name;
  NumberType type = NumberType::float32;
  std::optional<NumberType> count_type{};  ///< of a list
  std::size_t count = 1;                   ///< of numbers; not of a list
};

/// An element of a file, such as "vertex".
struct PointElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PointProperty> properties{};
};

/// Reads an element; stores vertices and faces, skips others. The intensity is the colours'
/// luminance if there is none.
void read_element(const PointElement& element, NumberReader& reader, StoredPoints& stored);

/// PLY declaration of the intensity. MeshLab interprets a 32-bit float intensity as grey of 0 to 1
/// and paints the points white, ignoring their colours; it ignores a double.
inline constexpr const char* ply_intensity = "property double intensity\n";

}  // namespace slipstream
