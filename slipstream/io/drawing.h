#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "slipstream/io/file.h"

namespace slipstream {

/// `size`: of the font, 0.45 for ordinary text.
inline void draw_text(cv::Mat& picture, const std::string& text, cv::Point at, double size,
                      const cv::Scalar& ink) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, ink, 1, cv::LINE_AA);
}

/// Throws as write_file.
inline void write_png(const std::filesystem::path& path, const cv::Mat& picture) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, 9});
  write_file(path, bytes);
}

}  // namespace slipstream
