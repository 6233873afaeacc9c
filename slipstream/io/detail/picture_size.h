#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace slipstream {

/// The pixels that the header of a PNG, TIFF, BMP or PGM file says it has, or those of one of its
/// tiles where they are more; nothing where it is none of these.
std::optional<std::uint64_t> stated_pixels(std::span<const std::uint8_t> bytes);

/// Takes the next number off a PGM file's text, past blanks and comments.
std::optional<std::uint32_t> next_number(std::string_view& text);

}  // namespace slipstream
