#pragma once

#include <filesystem>
#include <string>

#include <opencv2/core.hpp>

#include "slipstream/base/image.h"

namespace slipstream {

/// An OpenCV header over the same pixels, to read; valid as long as they are.
template <class Pixel>
cv::Mat mat_of(ImageView<const Pixel> image) {
  return {image.height(), image.width(), cv::traits::Type<Pixel>::value,
          const_cast<Pixel*>(image.row(0)),  // cv::Mat has no const form
          static_cast<std::size_t>(image.stride()) * sizeof(Pixel)};
}

template <class Pixel>
cv::Mat mat_of(const Image<Pixel>& image) {
  return mat_of(ImageView<const Pixel>(image));
}

/// A copy of an OpenCV picture of one channel of that pixel type.
template <class Pixel>
Image<Pixel> image_from(const cv::Mat& mat) {
  CV_Assert(mat.type() == cv::traits::Type<Pixel>::value);
  Image<Pixel> image({mat.cols, mat.rows}, uninitialised);
  mat.copyTo(mat_of(image));
  return image;
}

/// `size`: of the font, 0.45 for ordinary text.
void draw_text(cv::Mat& picture, const std::string& text, cv::Point at, double size,
               const cv::Scalar& ink);

/// Writes blue, green and red of 8 bits. Throws as write_file.
void write_png(const std::filesystem::path& path, const cv::Mat& picture);

}  // namespace slipstream
