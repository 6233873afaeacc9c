#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slipstream {

/// A number as networks send it, the highest byte first.
template <std::unsigned_integral Number>
Number big_endian_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  Number number = 0;
  for (const auto byte : bytes.subspan(at, sizeof(Number))) {
    number = static_cast<Number>(number << 8 | byte);
  }
  return number;
}

template <std::unsigned_integral Number>
void append_big_endian(std::vector<std::uint8_t>& bytes, Number number) {
  for (int shift = 8 * (sizeof(Number) - 1); shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(number >> shift));
  }
}

}  // namespace slipstream
