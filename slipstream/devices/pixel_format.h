#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// How a camera lays its pixels out in memory, row behind row without a gap. Named as GenICam names
/// them.
enum class PixelFormat {
  mono8,   ///< a byte
  mono10,  ///< two bytes, the low one first, as with mono12 and mono16
  mono12,
  mono16,
  mono10p,        ///< bit behind bit, the low ones first: 4 pixels in 5 bytes
  mono12p,        ///< bit behind bit, the low ones first: 2 pixels in 3 bytes
  mono10_packed,  ///< 2 pixels in 3 bytes: high bits, the low bits of both, high bits
  mono12_packed,  ///< 2 pixels in 3 bytes: high bits, the low bits of both, high bits
  rgb8,           ///< in colour: a byte each for red, green and blue
};

/// "Mono8", "Mono10", "Mono12", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed",
/// "RGB8".
std::string_view name_of(PixelFormat format);
std::vector<std::string_view> pixel_format_names();

/// The format of that name. Throws Error for another.
PixelFormat pixel_format_named(std::string_view name);

/// 8, 10, 12 or 16.
int bits_of(PixelFormat format);

/// Of a pixel: 3 in colour, else 1. So many times as wide are frames of it.
int values_of(PixelFormat format);

/// Bytes of a picture of so many values.
std::size_t bytes_of(PixelFormat format, std::size_t values);

/// Unpacks a picture into `frame`, which is of its size and bits. False, and nothing is written,
/// where there are fewer bytes than its values take.
bool unpack(PixelFormat format, std::span<const std::uint8_t> bytes, Frame& frame);

}  // namespace slipstream
