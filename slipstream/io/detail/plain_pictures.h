#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

// Pictures without compression. The readers throw Error, which does not name the file.
namespace slipstream {

/// The pixels of a BMP file: grey of 8 bits where its palette is, else blue, green and red.
cv::Mat read_bmp(std::span<const std::uint8_t> bytes);

/// The file of grey pixels of 8 bits or of blue, green and red; empty for others.
std::vector<std::uint8_t> bmp_file_of(const cv::Mat& mat);

/// The pixels of a PGM or PPM file, in letters or binary: of 8 bits, or 16 where it says more than
/// 255 levels, as they stand there; one channel, or blue, green and red.
cv::Mat read_pgm(std::span<const std::uint8_t> bytes);

/// The binary file of grey pixels of 8 or 16 bits; empty for others.
std::vector<std::uint8_t> pgm_file_of(const cv::Mat& mat);

}  // namespace slipstream
