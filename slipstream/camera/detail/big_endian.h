#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace slipstream {

/// The number in as many bytes as `Number` has at `at`, highest first, as networks send them. They
/// are within `bytes`.
template <std::unsigned_integral Number>
Number big_endian(std::span<const std::uint8_t> bytes, std::size_t at) {
  Number number = 0;
  for (const std::uint8_t byte : bytes.subspan(at, sizeof(Number))) {
    number = static_cast<Number>(number << 8 | byte);
  }
  return number;
}

/// Appends it so.
template <std::unsigned_integral Number>
void append_big_endian(std::vector<std::uint8_t>& bytes, Number number) {
  for (int shift = 8 * (sizeof(Number) - 1); shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(number >> shift));
  }
}

}  // namespace slipstream
