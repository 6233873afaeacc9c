#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "io/pictures.h"

namespace slipstream {

/// read_png for grey and RGB without interlacing, faster; nullopt for others and damaged files.
std::optional<Picture> read_plain_png(std::span<const std::uint8_t> bytes, std::size_t frames);

}  // namespace slipstream
