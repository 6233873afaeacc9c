#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace slipstream {

/// The pixels that the header of a PNG, TIFF, BMP or PGM file says it has, or those of one of its
/// tiles where they are more; nothing where it is none of these.
std::optional<std::uint64_t> stated_pixels(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
