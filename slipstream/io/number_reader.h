#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace slipstream {

enum class NumberType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

enum class NumberFormat { ascii, little_endian, big_endian };

/// Takes lines and numbers off the front of a file of points, never past its end. Throws Error,
/// which does not name the file, where it ends too soon.
class NumberReader {
 public:
  explicit NumberReader(std::span<const std::uint8_t> bytes)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()) {}

  std::string_view line();
  double number(NumberType type);
  /// Of the numbers to come; ASCII before.
  void set_format(NumberFormat format);
  /// What is not yet read: no element has more numbers than that has bytes.
  [[nodiscard]] std::string_view left() const { return text_; }

 private:
  double ascii_number();
  template <class Stored>
  double binary_number();

  std::string_view text_;
  bool ascii_ = true;
  bool swapped_ = false;
};

/// What stands between blanks.
std::vector<std::string_view> words_of(std::string_view line);

/// The number of things that a word says. Throws Error for any other word.
std::size_t count_from(std::string_view text);

}  // namespace slipstream
