#include "slipstream/io/detail/picture_size.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <string_view>

#include "slipstream/base/number_text.h"
#include "slipstream/io/detail/png_file.h"

namespace slipstream {
namespace {

using Bytes = std::span<const std::uint8_t>;

/// Numbers at an offset, 0 behind the end.
struct Header {
  Bytes bytes;
  bool little_endian;

  [[nodiscard]] std::uint64_t number(std::uint64_t at, std::uint64_t size) const {
    if (at > bytes.size() || bytes.size() - at < size) return 0;
    std::uint64_t value = 0;
    for (std::uint64_t i = 0; i < size; ++i) {
      value = value << 8 | bytes[at + (little_endian ? size - 1 - i : i)];
    }
    return value;
  }
};

std::uint64_t bmp_pixels(const Header& header) {
  if (header.number(14, 4) == 12) return header.number(18, 2) * header.number(20, 2);
  const auto height = static_cast<std::int32_t>(header.number(22, 4));  // negative: top row first
  return header.number(18, 4) * static_cast<std::uint64_t>(std::abs(std::int64_t{height}));
}

std::uint64_t pgm_pixels(std::string_view text) {
  const std::uint64_t columns = next_number(text).value_or(0);
  return columns * next_number(text).value_or(0);
}

/// Of the first directory: the widths and heights of picture and tiles.
std::uint64_t tiff_pixels(const Header& header) {
  const bool big = header.number(2, 2) == 43;
  const std::uint64_t word = big ? 8 : 4, entry = big ? 20 : 12;
  const std::uint64_t directory = header.number(word, word), of_count = big ? 8 : 2;
  std::array<std::uint64_t, 2> picture{}, tile{};
  for (std::uint64_t n = header.number(directory, of_count), at = directory + of_count;
       n > 0 && at < header.bytes.size(); --n, at += entry) {
    const std::uint64_t type = header.number(at + 2, 2);
    const bool is_short = type == 3 || type == 8, is_byte = type == 1 || type == 6;
    const std::uint64_t size = is_byte ? 1 : is_short ? 2 : type < 16 ? 4 : 8;
    const std::uint64_t value = header.number(at + 4 + word, size);
    const std::uint64_t tag = header.number(at, 2);
    if (tag == 256 || tag == 257) picture[tag - 256] = std::max(picture[tag - 256], value);
    if (tag == 322 || tag == 323) tile[tag - 322] = std::max(tile[tag - 322], value);
  }
  const auto pixels = [](const auto& sides) {
    return std::min(sides[0], std::uint64_t{1} << 31) * std::min(sides[1], std::uint64_t{1} << 31);
  };
  return std::max(pixels(picture), pixels(tile));
}

}  // namespace

std::optional<std::uint32_t> next_number(std::string_view& text) {
  while (!text.empty() && !std::isdigit(static_cast<unsigned char>(text[0]))) {
    text.remove_prefix(text[0] == '#' ? std::min(text.find('\n'), text.size()) : 1);
  }
  const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  const auto number = number_in<std::uint32_t>(text.substr(0, digits));
  text.remove_prefix(digits);
  return number;
}

std::optional<std::uint64_t> stated_pixels(Bytes bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto begins = [&](std::string_view start) { return text.starts_with(start); };
  const Header little{bytes, true}, big{bytes, false};
  if (is_png(bytes)) return big.number(16, 4) * big.number(20, 4);
  if (begins("BM")) return bmp_pixels(little);
  if (begins({"II*\0", 4}) || begins({"II+\0", 4})) return tiff_pixels(little);
  if (begins({"MM\0*", 4}) || begins({"MM\0+", 4})) return tiff_pixels(big);
  if (begins("P") && text.size() > 2 && text[1] >= '1' && text[1] <= '6' &&
      std::isspace(static_cast<unsigned char>(text[2])) != 0) {
    return pgm_pixels(text.substr(2));
  }
  return std::nullopt;
}

}  // namespace slipstream
