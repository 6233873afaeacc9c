#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace slipstream {

/// Whether the bytes start as a PNG file does.
bool is_png(std::span<const std::uint8_t> bytes);

/// What is wrong with the chunks of a PNG file ("it is truncated"), or nothing. A decoder that
/// meets such a file prints words of its own and may hand out half a picture.
std::string png_fault(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
