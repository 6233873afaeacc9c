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

namespace slipstream {

inline constexpr double two_pi = 2 * std::numbers::pi;    ///< a whole turn, in radians
inline constexpr double degree = std::numbers::pi / 180;  ///< radians
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// The numbers that a text as "2,0,1" says, with that mark between each and the next; empty for any
/// other text.
template <class Number>
std::vector<Number> numbers_in(std::string_view text, char mark) {
  std::vector<Number> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (true) {
    Number number{};
    const auto [after, failure] = std::from_chars(at, end, number);
    if (failure != std::errc()) return {};
    numbers.push_back(number);
    if (after == end) return numbers;
    if (*after != mark) return {};
    at = after + 1;
  }
}

/// The number that a text says; none for any other text.
template <class Number>
std::optional<Number> number_in(std::string_view text) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [after, failure] = std::from_chars(text.data(), end, number);
  return failure == std::errc() && after == end ? std::optional(number) : std::nullopt;
}

static_assert(std::endian::native == std::endian::little);

/// Adds the bytes of each number in that order; of a few numbers in a row as they lie in memory.
template <std::endian Order = std::endian::little, class Bytes, class... Numbers>
void append_numbers(Bytes& bytes, const Numbers&... numbers) {
  const auto add = [&](const auto& number) {
    using Byte = typename Bytes::value_type;
    const auto* const first = reinterpret_cast<const Byte*>(&number);
    if constexpr (std::is_same_v<Byte, char> && Order == std::endian::little) {
      bytes.append(first, sizeof number);
    } else {  // compilers see faults in inserting them at once
      for (std::size_t i = 0; i < sizeof number; ++i) {
        bytes.push_back(first[Order == std::endian::little ? i : sizeof number - 1 - i]);
      }
    }
  };
  (add(numbers), ...);
}

/// The number that those bytes make, which are there.
template <class Number, std::endian Order = std::endian::little>
Number number_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::array<std::uint8_t, sizeof(Number)> own;
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), own.size(), own.begin());
  if (Order == std::endian::big) std::reverse(own.begin(), own.end());
  return std::bit_cast<Number>(own);
}

}  // namespace slipstream
