#pragma once

#include <cstdint>
#include <span>

#include <opencv2/core.hpp>

namespace slipstream {

/// Whether the bytes begin as those of a PNG file do.
bool is_png(std::span<const std::uint8_t> bytes);

/// The pixels of a PNG file, of 8 or 16 bits, without alpha: one channel, or blue, green and red.
/// Throws Error, which does not name the file, where it is not whole: each of its check sums must
/// fit. OpenCV reads a truncated one as far as it goes, and libpng then writes to the terminal.
cv::Mat read_png(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
