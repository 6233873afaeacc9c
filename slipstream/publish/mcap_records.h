#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "slipstream/base/number_bytes.h"

/// What stands in MCAP files: mcap.dev/spec.
namespace slipstream::mcap {

inline constexpr std::array<std::uint8_t, 8> magic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
enum Opcode : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0a,
  statistics = 0x0b,
  summary_offset = 0x0e,
  data_end = 0x0f,
};

/// Adds what a record says: numbers, texts behind their length in 32 bits, and bytes.
template <class... Values>
void append(std::vector<std::uint8_t>& record, const Values&... values) {
  const auto add = [&](const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_arithmetic_v<Value>) {
      append_numbers(record, value);
    } else if constexpr (std::is_convertible_v<Value, std::string_view>) {
      append_numbers(record, static_cast<std::uint32_t>(value.size()));
      for (const char letter : value) record.push_back(static_cast<std::uint8_t>(letter));
    } else {
      record.insert(record.end(), value.begin(), value.end());
    }
  };
  (add(values), ...);
}

}  // namespace slipstream::mcap
