#pragma once

#include <filesystem>

#include "slipstream/base/image.h"

namespace slipstream {

/// Whether the file's ending is pdf, svg or png.
bool is_print_file(const std::filesystem::path& path);

/// Writes a black and white picture to print at true size: a page, .pdf or .svg, with dark pixels
/// as rectangles and below them a ruler of up to 100 mm to check the print with; or a .png that
/// holds its resolution.
void write_print(const std::filesystem::path& path, const Image<std::uint8_t>& picture,
                 double mm_per_pixel);

}  // namespace slipstream
