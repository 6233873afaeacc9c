#pragma once

#include <filesystem>
#include <string>

#include <opencv2/imgproc.hpp>

namespace slipstream {

/// `size`: of the font, 0.45 for ordinary text.
void draw_text(cv::Mat& picture, const std::string& text, cv::Point at, double size,
               const cv::Scalar& ink);

/// Throws as write_file.
void write_png(const std::filesystem::path& path, const cv::Mat& picture);

}  // namespace slipstream
