#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

#include "base/numbers.h"
#include "slipstream/error.h"
#include "slipstream/ros_messages.h"

namespace slipstream {

/// Appends numbers and texts with CDR alignment.
class Cdr {
 public:
  /// Restarts the message, reusing its memory.
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

  /// A count or a length.
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

  /// Appends a list of this many bytes; fill it before appending more.
  std::span<std::uint8_t> add_bytes(std::size_t count) {
    add_count(count);
    message_.resize(message_.size() + count);
    return std::span(message_).last(count);
  }

 private:
  RosMessage& message_;
};

/// Reads numbers and texts from untrusted bytes. Throws Error if they end too soon.
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

  /// A text after its 32-bit length.
  std::string_view text() {
    const auto letters = take(get<std::uint32_t>());
    return {reinterpret_cast<const char*>(letters.data()), letters.size()};
  }

  /// Skips to the next multiple of `size` from the beginning.
  void align(std::size_t size) { take((size - at_ % size) % size); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

/// Reads an untrusted CDR message. The constructor throws Error if it is not little-endian CDR.
class CdrReader : private ByteReader {
 public:
  explicit CdrReader(std::span<const std::uint8_t> message) : ByteReader(content_of(message)) {}

  template <class Number>
  Number get() {
    align(sizeof(Number));
    return ByteReader::get<Number>();
  }

  std::uint32_t count() { return get<std::uint32_t>(); }

  std::string_view text() {
    align(4);
    const std::string_view text = ByteReader::text();
    return text.substr(0, text.find('\0'));
  }

  /// A list of numbers of this many bytes each.
  std::span<const std::uint8_t> list(std::size_t size = 1) {
    const std::uint64_t numbers = count();
    if (numbers > 0) align(size);
    return take(numbers * size);
  }

 private:
  static std::span<const std::uint8_t> content_of(std::span<const std::uint8_t> message) {
    if (message.size() < 4 || message[0] != 0 || message[1] != 1) {
      throw Error("message is not little-endian CDR");
    }
    return message.subspan(4);
  }
};

}  // namespace slipstream
