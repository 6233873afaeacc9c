#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include <gtest/gtest.h>

namespace slipstream {

/// Reads consecutive little-endian values.
struct LittleEndianReader {
  std::span<const std::uint8_t> bytes;
  std::size_t at = 0;

  template <class Number>
  Number get() {
    Number number;
    std::memcpy(&number, take(sizeof number).data(), sizeof number);
    return number;
  }
  std::span<const std::uint8_t> take(std::size_t count) {
    EXPECT_LE(at + count, bytes.size());
    at += count;
    return bytes.subspan(at - count, count);
  }
  std::string text() {
    const auto length = get<std::uint32_t>();
    const auto letters = take(length);
    return {letters.begin(), letters.end()};
  }
  /// CDR alignment, counted from the end of the 4-byte header.
  template <class Number>
  Number aligned() {
    while ((at - 4) % sizeof(Number) != 0) ++at;
    return get<Number>();
  }
  std::string aligned_text() {
    const auto length = aligned<std::uint32_t>();
    const auto letters = take(length);
    EXPECT_EQ(letters.back(), 0);
    return {letters.begin(), letters.end() - 1};
  }
};

}  // namespace slipstream
