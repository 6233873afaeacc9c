#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "slipstream/error/error.h"

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

/// Takes numbers and texts off the front of bytes that anybody may have made. Each throws Error
/// where they end too soon.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  std::span<const std::uint8_t> take(std::uint64_t count) {
    if (count > left()) throw Error("it ends too soon");
    at_ += count;
    return bytes_.subspan(at_ - count, count);
  }
  template <class Number>
  Number get() {
    Number number;
    std::memcpy(&number, take(sizeof number).data(), sizeof number);
    return number;
  }
  /// Behind its length in 32 bits.
  std::string_view text() {
    const auto letters = take(get<std::uint32_t>());
    return {reinterpret_cast<const char*>(letters.data()), letters.size()};
  }
  /// Goes on at the next multiple of `size`, counted from the begin.
  void align(std::size_t size) { take((size - at_ % size) % size); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace slipstream
