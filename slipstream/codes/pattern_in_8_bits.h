#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/base/colour.h"
#include "slipstream/base/image.h"
#include "slipstream/codes/pattern_set.h"

namespace slipstream {

/// A pattern rendered for a projector of 8 bits, in pixels of 8 bits.
Image<std::uint8_t> in_8_bits(const Image<std::uint16_t>& pattern);

/// All patterns of a set, so rendered.
std::vector<Image<std::uint8_t>> patterns_in_8_bits(const PatternSet& set, Size projector);

/// Three of its patterns, from `first` on, as red, green and blue of one picture.
Image<Colour> picture_in_colour(const PatternSet& set, int first, Size projector);

}  // namespace slipstream
