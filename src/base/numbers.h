#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

inline constexpr double two_pi = 2 * std::numbers::pi;    ///< a full turn, rad
inline constexpr double degree = std::numbers::pi / 180;  ///< radians
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// number_in<double> by std::strtod, for standard libraries whose std::from_chars takes only
/// integers.
std::optional<double> number_by_strtod(std::string_view text);

/// Parses a number; nullopt unless the whole text is one.
template <class Number>
std::optional<Number> number_in(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  if constexpr (requires { std::from_chars(end, end, number); }) {
    const auto [after, failure] = std::from_chars(text.data(), end, number);
    return failure == std::errc() && after == end ? std::optional(number) : std::nullopt;
  } else {
    return number_by_strtod(text);
  }
}

/// Parses numbers separated by `mark`, such as "2,0,1"; any other text gives an empty list.
template <class Number>
std::vector<Number> numbers_in(std::string_view text, char mark) {
  std::vector<Number> numbers;

  while (true) {
    const std::size_t end = std::min(text.find(mark), text.size());
    const auto number = number_in<Number>(text.substr(0, end));
    if (!number) return {};

    numbers.push_back(*number);
    if (end == text.size()) return numbers;
    text.remove_prefix(end + 1);
  }
}

/// Removes and returns the text before `mark`, and removes the mark; all without a mark.
inline std::string_view take_until(std::string_view& text, char mark) {
  const std::string_view taken = text.substr(0, text.find(mark));
  text.remove_prefix(std::min(taken.size() + 1, text.size()));
  return taken;
}

/// Parses a size such as "1824x1140", 1 to 65536 pixels each way; nullopt for any other text.
inline std::optional<Size> size_of_text(std::string_view text) {
  const std::vector<int> sides = numbers_in<int>(text, 'x');
  const bool good = sides.size() == 2 && std::min(sides[0], sides[1]) >= 1 &&
                    std::max(sides[0], sides[1]) <= 65536;
  return good ? std::optional(Size{sides[0], sides[1]}) : std::nullopt;
}

/// Parses a rectangle: "640x480+16+8" is width x height + x + y, "640x480" starts at 0, 0. nullopt
/// for any other text.
inline std::optional<Rectangle> rectangle_of_text(std::string_view text) {
  const std::size_t plus = std::min(text.find('+'), text.size());
  const std::optional<Size> size = size_of_text(text.substr(0, plus));

  if (!size || plus == text.size())
    return size ? std::optional(Rectangle{0, 0, *size}) : std::nullopt;

  const std::vector<int> place = numbers_in<int>(text.substr(plus + 1), '+');
  if (place.size() != 2 || place[0] < 0 || place[1] < 0) return std::nullopt;
  return Rectangle{place[0], place[1], *size};
}

static_assert(std::endian::native == std::endian::little);

/// Appends the bytes of each number in that order; an array of numbers as it lies in memory.
template <std::endian Order = std::endian::little, class Bytes, class... Numbers>
void append_numbers(Bytes& bytes, const Numbers&... numbers) {
  const auto add = [&](const auto& number) {
    using Byte = typename Bytes::value_type;
    const auto* const first = reinterpret_cast<const Byte*>(&number);
    if constexpr (std::is_same_v<Byte, char> && Order == std::endian::little) {
      bytes.append(first, sizeof number);
    } else {  // compilers warn falsely about inserting all at once
      for (std::size_t i = 0; i < sizeof number; ++i) {
        bytes.push_back(first[Order == std::endian::little ? i : sizeof number - 1 - i]);
      }
    }
  };
  (add(numbers), ...);
}

/// The number in the bytes from `at` on; they must exist.
template <class Number, std::endian Order = std::endian::little>
Number number_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::array<std::uint8_t, sizeof(Number)> own;
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), own.size(), own.begin());
  if (Order == std::endian::big) std::reverse(own.begin(), own.end());
  return std::bit_cast<Number>(own);
}

}  // namespace slipstream
