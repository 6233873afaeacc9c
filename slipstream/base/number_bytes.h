#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace slipstream {
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
