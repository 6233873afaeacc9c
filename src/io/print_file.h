#pragma once

#include <cstdint>
#include <filesystem>

#include "slipstream/image.h"

namespace slipstream {

/// Writes a black and white picture to print at true size: a page, .pdf or .svg, with dark pixels
/// as rectangles and below them a ruler of up to 100 mm to check the print with; or a .png that
/// holds its resolution; or any other picture, see write_image.
void write_print(const std::filesystem::path& path, const Image<std::uint8_t>& picture,
                 double mm_per_pixel);

}  // namespace slipstream
