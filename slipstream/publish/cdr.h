#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "slipstream/base/error.h"
#include "slipstream/base/numbers.h"

namespace slipstream {

/// A message of ROS 2 in its binary form: CDR, little-endian.
using RosMessage = std::vector<std::uint8_t>;

/// Adds numbers and texts one after the other, each where CDR aligns it.
class Cdr {
 public:
  /// Begins the message anew; its memory is used.
  explicit Cdr(RosMessage& message) : message_(message) {
    message_.assign({0, 1, 0, 0});  // CDR, little-endian
  }

  template <class Number>
  Cdr& add(Number number) {
    const std::size_t at = message_.size() + (4 - message_.size()) % sizeof number;
    message_.resize(at + sizeof number);
    std::memcpy(&message_[at], &number, sizeof number);
    return *this;
  }
  /// How many follow, or how long something is.
  Cdr& add_count(std::size_t count) { return add(static_cast<std::uint32_t>(count)); }
  Cdr& add_text(std::string_view text) {
    add_count(text.size() + 1);
    message_.insert(message_.end(), text.begin(), text.end());
    message_.push_back(0);
    return *this;
  }
  /// Seconds and nanoseconds.
  Cdr& add_time(std::uint64_t nanoseconds) {
    constexpr std::uint64_t second = 1'000'000'000;
    add(static_cast<std::int32_t>(nanoseconds / second));
    return add(static_cast<std::uint32_t>(nanoseconds % second));
  }
  Cdr& add_header(std::uint64_t time) { return add_time(time).add_text("camera"); }
  /// A list of so many bytes, to be filled before more is added.
  std::span<std::uint8_t> add_bytes(std::size_t count) {
    add_count(count);
    message_.resize(message_.size() + count);
    return std::span(message_).last(count);
  }

 private:
  RosMessage& message_;
};

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

/// Takes them off the front of a message that anybody may have made. Each throws Error where it
/// ends too soon, the constructor where it is no such message.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::uint8_t> message) : rest_(content_of(message)) {}

  template <class Number>
  Number get() {
    rest_.align(sizeof(Number));
    return rest_.get<Number>();
  }
  std::uint32_t count() { return get<std::uint32_t>(); }
  std::string_view text() {
    rest_.align(4);
    const std::string_view text = rest_.text();
    return text.substr(0, text.find('\0'));
  }
  /// Those of a list of numbers of so many bytes each.
  std::span<const std::uint8_t> list(std::size_t size = 1) {
    const std::uint64_t numbers = count();
    if (numbers > 0) rest_.align(size);
    return rest_.take(numbers * size);
  }

 private:
  static std::span<const std::uint8_t> content_of(std::span<const std::uint8_t> message) {
    if (message.size() < 4 || message[0] != 0 || message[1] != 1) {
      throw Error("a message is no little-endian CDR");
    }
    return message.subspan(4);
  }

  ByteReader rest_;
};

}  // namespace slipstream
