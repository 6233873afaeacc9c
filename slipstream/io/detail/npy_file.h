#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

namespace slipstream {

/// The numbers of a NumPy file, rows x columns of 32- or 64-bit float as numpy.save writes them.
/// Throws Error, which does not name the file, where it is not whole or holds anything else.
cv::Mat read_npy(std::span<const std::uint8_t> bytes);

/// The file of such numbers.
std::vector<std::uint8_t> npy_file_of(const cv::Mat& mat);

}  // namespace slipstream
