#include "slipstream/devices/pixel_format.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

static_assert(std::endian::native == std::endian::little,
              "pixels of two bytes come as this machine keeps them");

struct FormatDescription {
  PixelFormat format;
  std::string_view name;
  int bits;         ///< of the camera
  int stored_bits;  ///< that a value takes
};

constexpr std::array<FormatDescription, 9> formats{{
    {PixelFormat::mono8, "Mono8", 8, 8},
    {PixelFormat::mono10, "Mono10", 10, 16},
    {PixelFormat::mono12, "Mono12", 12, 16},
    {PixelFormat::mono16, "Mono16", 16, 16},
    {PixelFormat::mono10p, "Mono10p", 10, 10},
    {PixelFormat::mono12p, "Mono12p", 12, 12},
    {PixelFormat::mono10_packed, "Mono10Packed", 10, 12},
    {PixelFormat::mono12_packed, "Mono12Packed", 12, 12},
    {PixelFormat::rgb8, "RGB8", 8, 8},
}};

const FormatDescription& describe(PixelFormat format) {
  return *std::find_if(formats.begin(), formats.end(),
                       [&](const auto& known) { return known.format == format; });
}

/// Pixels of `bits` one behind another, the low bits first.
void unpack_bits(int bits, const std::uint8_t* bytes, std::span<std::uint16_t> pixels) {
  const std::uint32_t mask = (1U << bits) - 1;
  std::uint32_t held = 0;
  int held_bits = 0;
  for (std::uint16_t& pixel : pixels) {
    for (; held_bits < bits; held_bits += 8) {
      held |= static_cast<std::uint32_t>(*bytes++) << held_bits;
    }
    pixel = static_cast<std::uint16_t>(held & mask);
    held >>= bits;
    held_bits -= bits;
  }
}

/// Two pixels in three bytes: the high eight bits of each, and between them the low bits of the
/// first in the low half, of the second in the high half.
void unpack_pairs(int bits, const std::uint8_t* bytes, std::span<std::uint16_t> pixels) {
  const int low_bits = bits - 8;
  const int mask = (1 << low_bits) - 1;
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const std::uint8_t* pair = bytes + i / 2 * 3;
    const int high = i % 2 == 0 ? pair[0] : pair[2];
    const int low = (i % 2 == 0 ? pair[1] : pair[1] >> 4) & mask;
    pixels[i] = static_cast<std::uint16_t>(high << low_bits | low);
  }
}

void unpack(PixelFormat format, const std::uint8_t* bytes, std::span<std::uint16_t> pixels) {
  switch (format) {
    case PixelFormat::mono10p:
    case PixelFormat::mono12p:
      return unpack_bits(bits_of(format), bytes, pixels);
    case PixelFormat::mono10_packed:
    case PixelFormat::mono12_packed:
      return unpack_pairs(bits_of(format), bytes, pixels);
    default:
      std::memcpy(pixels.data(), bytes, pixels.size_bytes());
  }
}

}  // namespace

std::string_view name_of(PixelFormat format) {
  return describe(format).name;
}

std::vector<std::string_view> pixel_format_names() {
  std::vector<std::string_view> names;
  for (const FormatDescription& format : formats) names.push_back(format.name);
  return names;
}

PixelFormat pixel_format_named(std::string_view name) {
  for (const FormatDescription& format : formats) {
    if (format.name == name) return format.format;
  }
  throw Error(fmt::format("pixel format '{}' is not known; there are: {}", name,
                          fmt::join(pixel_format_names(), ", ")));
}

int bits_of(PixelFormat format) {
  return describe(format).bits;
}

int values_of(PixelFormat format) {
  return format == PixelFormat::rgb8 ? 3 : 1;
}

std::size_t bytes_of(PixelFormat format, std::size_t values) {
  if (format == PixelFormat::mono10_packed || format == PixelFormat::mono12_packed) {
    return (values + 1) / 2 * 3;
  }
  return (values * static_cast<std::size_t>(describe(format).stored_bits) + 7) / 8;
}

bool unpack(PixelFormat format, std::span<const std::uint8_t> bytes, Frame& frame) {
  if (auto* image = std::get_if<Image<std::uint8_t>>(&frame.pixels)) {
    if (bytes.size() < image->pixel_count()) return false;
    std::copy_n(bytes.begin(), image->pixel_count(), image->begin());
    return true;
  }
  auto& image = std::get<Image<std::uint16_t>>(frame.pixels);
  if (bytes.size() < bytes_of(format, image.pixel_count())) return false;
  unpack(format, bytes.data(), {image.begin(), image.pixel_count()});
  return true;
}

}  // namespace slipstream
