#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "slipstream/base/error.h"
#include "slipstream/base/number_bytes.h"

namespace slipstream {

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
    return number_at<Number>(take(sizeof(Number)), 0);
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
