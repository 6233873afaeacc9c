#pragma once

#include <cstdint>

#include "slipstream/base/image.h"

namespace slipstream {

/// 1 where the modulation B^c (grey levels) is at least `minimum`, 0 where the pixel is in shadow,
/// too dark or unlit and its phase means nothing (Liu 2010, Section 1.1).
Image<std::uint8_t> modulation_mask(const Image<double>& modulation, double minimum);

}  // namespace slipstream
