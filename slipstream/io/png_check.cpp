#include "slipstream/io/png_check.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <zlib.h>

namespace slipstream {
namespace {

constexpr std::array<std::uint8_t, 8> signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

std::uint32_t big_endian(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(bytes[0]) << 24 | static_cast<std::uint32_t>(bytes[1]) << 16 |
         static_cast<std::uint32_t>(bytes[2]) << 8 | static_cast<std::uint32_t>(bytes[3]);
}

std::uint32_t check_sum(std::span<const std::uint8_t> bytes) {
  return static_cast<std::uint32_t>(crc32_z(crc32_z(0, nullptr, 0), bytes.data(), bytes.size()));
}

}  // namespace

bool is_png(std::span<const std::uint8_t> bytes) {
  return bytes.size() >= signature.size() &&
         std::equal(signature.begin(), signature.end(), bytes.begin());
}

std::string png_fault(std::span<const std::uint8_t> bytes) {
  if (!is_png(bytes)) return "it is not a PNG file";
  bytes = bytes.subspan(signature.size());
  while (true) {
    constexpr std::size_t length_size = 4, type_size = 4, sum_size = 4;
    if (bytes.size() < length_size + type_size + sum_size) return "it is truncated";
    const std::size_t length = big_endian(bytes);
    bytes = bytes.subspan(length_size);
    if (bytes.size() < type_size + length + sum_size) return "it is truncated";
    const std::string_view type(reinterpret_cast<const char*>(bytes.data()), type_size);
    const std::span<const std::uint8_t> type_and_data = bytes.first(type_size + length);
    bytes = bytes.subspan(type_size + length);
    if (check_sum(type_and_data) != big_endian(bytes)) {
      return "it is damaged: a check sum does not fit";
    }
    bytes = bytes.subspan(sum_size);
    if (type == "IEND") return "";
  }
}

}  // namespace slipstream
