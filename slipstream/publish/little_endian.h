#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

namespace slipstream {
static_assert(std::endian::native == std::endian::little);

/// Adds a number's bytes.
template <class Number>
requires std::is_arithmetic_v<Number>
void append(std::vector<std::uint8_t>& bytes, Number number) {
  for (const std::uint8_t byte : std::bit_cast<std::array<std::uint8_t, sizeof number>>(number)) {
    bytes.push_back(byte);
  }
}

inline void append(std::vector<std::uint8_t>& bytes, std::span<const std::uint8_t> more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}

/// Adds its length in 32 bits, and the text.
inline void append(std::vector<std::uint8_t>& bytes, std::string_view text) {
  append(bytes, static_cast<std::uint32_t>(text.size()));
  bytes.insert(bytes.end(), text.begin(), text.end());
}

/// Adds each of them.
template <class First, class Second, class... More>
void append(std::vector<std::uint8_t>& bytes, const First& first, const Second& second,
            const More&... more) {
  append(bytes, first);
  append(bytes, second, more...);
}

}  // namespace slipstream
