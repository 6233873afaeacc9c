#pragma once

#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

namespace slipstream {

/// While it lives, OpenCV prints nothing of its own: what goes wrong comes out as an exception, and
/// a library does not write to its caller's terminal.
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

}  // namespace slipstream
