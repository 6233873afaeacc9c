#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.h"
#include "geometry/rotation.h"
#include "slipstream/image.h"

namespace slipstream {

/// Silences OpenCV's own output while it lives: errors arrive as exceptions, and a library must not
/// write to its caller's terminal.
class QuietOpenCv {
 public:
  QuietOpenCv()
      : level_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)),
        callback_(cv::redirectError(silent)) {}

  QuietOpenCv(const QuietOpenCv&) = delete;
  QuietOpenCv& operator=(const QuietOpenCv&) = delete;

  ~QuietOpenCv() {
    cv::redirectError(callback_);
    cv::utils::logging::setLogLevel(level_);
  }

 private:
  static int silent(int, const char*, const char*, const char*, int, void*) { return 0; }

  cv::utils::logging::LogLevel level_;
  cv::ErrorCallback callback_;
};

/// A read-only OpenCV header over the same pixels; valid as long as the image.
template <class Pixel>
cv::Mat mat_of(const Image<Pixel>& image) {
  return {image.height(), image.width(), cv::traits::Type<Pixel>::value,
          const_cast<Pixel*>(image.row(0))};  // cv::Mat has no const form
}

/// A copy of an OpenCV picture, grey or RGB.
template <class Pixel>
Image<Pixel> image_from(const cv::Mat& mat) {
  CV_Assert(mat.isContinuous() && mat.elemSize() == sizeof(Pixel));
  Image<Pixel> image({mat.cols, mat.rows}, uninitialised);
  std::memcpy(image.begin(), mat.data, mat.total() * sizeof(Pixel));
  return image;
}

/// The pixel nearest to a place.
inline cv::Point nearest_pixel(const Eigen::Vector2d& place) {
  return {cvRound(place.x()), cvRound(place.y())};
}

/// A mask of the given size: 1 within the hull of the pixels, 0 outside.
inline cv::Mat within_hull(const std::vector<cv::Point>& pixels, cv::Size size) {
  std::vector<cv::Point> hull;
  cv::convexHull(pixels, hull);

  cv::Mat mask(size, CV_8U, cv::Scalar(0));
  cv::fillConvexPoly(mask, hull, cv::Scalar(1));
  return mask;
}

/// Stretches the contrast from the 1st to the 99.5th percentile over 8 bits, for the detectors.
inline cv::Mat stretched(const cv::Mat& picture) {
  std::vector<float> values(picture.begin<float>(), picture.end<float>());
  const double low = quantile(values, 0.01),
               high = std::max<double>(quantile(values, 0.995), low + 1);

  cv::Mat grey;
  picture.convertTo(grey, CV_8U, 255 / (high - low), -low * 255 / (high - low));
  return grey;
}

/// The pose of OpenCV's rotation vector and translation.
inline Eigen::Isometry3d pose_of(const cv::Mat& turn, const cv::Mat& translation) {
  return pose_from(rotation_of_vector(Eigen::Vector3d(turn.ptr<double>())),
                   Eigen::Vector3d(translation.ptr<double>()));
}

}  // namespace slipstream
