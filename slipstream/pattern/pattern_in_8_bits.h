#pragma once

#include <cstdint>

#include "slipstream/image/image.h"

namespace slipstream {

/// A pattern rendered for a projector of 8 bits, in pixels of 8 bits.
Image<std::uint8_t> in_8_bits(const Image<std::uint16_t>& pattern);

}  // namespace slipstream
