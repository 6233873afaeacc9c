#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

namespace slipstream {

/// The pixels of a TIFF file's first picture: grey of 8 or 16 bits or of 32- or 64-bit float, or
/// blue, green and red (and alpha) of 8 or 16 bits. Throws Error, which does not name the file,
/// where it is not whole or holds other pixels.
cv::Mat read_tiff(std::span<const std::uint8_t> bytes);

/// The file of such pixels; without loss.
std::vector<std::uint8_t> tiff_file_of(const cv::Mat& mat);

}  // namespace slipstream
