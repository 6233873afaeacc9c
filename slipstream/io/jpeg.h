#pragma once

#include <span>

#include "slipstream/base/image.h"

namespace slipstream {

/// Decodes the luminance of a JPEG into `grey`. Returns false if the JPEG is damaged or of another
/// size.
bool decode_jpeg(std::span<const std::uint8_t> bytes, Image<std::uint8_t>& grey);

}  // namespace slipstream
