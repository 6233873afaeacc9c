#include "slipstream/io/drawing.h"

#include "slipstream/io/detail/png_file.h"
#include "slipstream/io/file.h"

namespace slipstream {

void draw_text(cv::Mat& picture, const std::string& text, cv::Point at, double size,
               const cv::Scalar& ink) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, ink, 1, cv::LINE_AA);
}

void write_png(const std::filesystem::path& path, const cv::Mat& picture) {
  write_file(path, png_file_of(picture));
}

}  // namespace slipstream
