#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include <opencv2/core.hpp>

#include "slipstream/base/image.h"

namespace slipstream {

/// Whether the bytes begin as those of a PNG file do.
bool is_png(std::span<const std::uint8_t> bytes);

/// What most frames are, grey, 8 or 16 bits, line by line, in half of libpng's time. None for other
/// pictures and those that are not whole: read_png says why.
std::optional<std::variant<Image<std::uint8_t>, Image<std::uint16_t>>> read_plain_grey(
    std::span<const std::uint8_t> bytes);

/// The pixels of a PNG file, of 8 or 16 bits, without alpha: one channel, or blue, green and red.
/// Throws Error, which does not name the file, where it is not whole: each of its check sums must
/// fit.
cv::Mat read_png(std::span<const std::uint8_t> bytes);

/// The file of such pixels, grey or in colour.
std::vector<std::uint8_t> png_file_of(const cv::Mat& mat);

/// The file, of one bit a pixel, of grey ones of 8 bits: 0 is dark, any other level bright.
std::vector<std::uint8_t> one_bit_png_file_of(const cv::Mat& mat);

}  // namespace slipstream
