#pragma once

#include <vector>

#include <opencv2/core/version.hpp>

#include "slipstream/calibration_board.h"

#if CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR < 7
#include <opencv2/aruco.hpp>
namespace cv::aruco {
/// The part of OpenCV 4.7's class that is used here.
struct ArucoDetector {
  Ptr<Dictionary> dictionary;

  [[nodiscard]] const Dictionary& getDictionary() const { return *dictionary; }
  void detectMarkers(const Mat& picture, std::vector<std::vector<Point2f>>& corners,
                     std::vector<int>& ids) const {
    aruco::detectMarkers(picture, dictionary, corners, ids);
  }
};
}  // namespace cv::aruco
#else
#include <opencv2/objdetect/aruco_detector.hpp>
#endif

namespace slipstream {

/// OpenCV's number of markers for each marker size.
inline constexpr int charuco_dictionary_size = 1000;

/// Holds and detects the board's markers. OpenCV's own ChArUco boards changed their pattern in 4.6.
inline cv::aruco::ArucoDetector marker_detector(const CalibrationBoard& board) {
  const int dictionary = cv::aruco::DICT_4X4_1000 + 4 * (board.marker_bits - 4);  // 4 of each size
  return cv::aruco::ArucoDetector{cv::aruco::getPredefinedDictionary(dictionary)};
}

/// Id of the marker in a bright square: row by row; the top left square is black.
inline int marker_id(const CalibrationBoard& board, int column, int row) {
  return (row * (board.columns + 1) + column) / 2;
}

}  // namespace slipstream
