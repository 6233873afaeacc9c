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
  DetectorParameters parameters;

  [[nodiscard]] const Dictionary& getDictionary() const { return *dictionary; }
  void detectMarkers(const Mat& picture, std::vector<std::vector<Point2f>>& corners,
                     std::vector<int>& ids) const {
    aruco::detectMarkers(picture, dictionary, corners, ids,
                         makePtr<DetectorParameters>(parameters));
  }
};
}  // namespace cv::aruco
#else
#include <opencv2/objdetect/aruco_detector.hpp>
#endif

namespace slipstream {

/// OpenCV's number of markers for each marker size.
inline constexpr int charuco_dictionary_size = 1000;

/// Holds and detects the markers of one of OpenCV's dictionaries.
inline cv::aruco::ArucoDetector detector_of(int dictionary) {
  // The outline of a margin of one bit is nearer to the marker than OpenCV's 0.05 of its perimeter,
  // and the larger of two near ones would be taken.
  cv::aruco::DetectorParameters parameters;
  parameters.minMarkerDistanceRate = 0.03;
  return cv::aruco::ArucoDetector{cv::aruco::getPredefinedDictionary(dictionary), parameters};
}

/// Detects the board's markers. OpenCV's own ChArUco boards changed their pattern in 4.6.
inline cv::aruco::ArucoDetector marker_detector(const CalibrationBoard& board) {
  return detector_of(cv::aruco::DICT_4X4_1000 + 4 * (board.marker_bits - 4));  // 4 of each size
}

/// A marker's bits, 0 or 255, with a black border of one cell.
inline cv::Mat marker_cells(const cv::aruco::Dictionary& dictionary, int number) {
  const int bits = dictionary.markerSize;
  cv::Mat cells = cv::Mat::zeros(bits + 2, bits + 2, CV_8U);
  cells({1, 1, bits, bits})
      .setTo(255,
             cv::aruco::Dictionary::getBitsFromByteList(dictionary.bytesList.row(number), bits));
  return cells;
}

/// Id of the marker in a bright square: row by row; the top left square is black.
inline int marker_id(const CalibrationBoard& board, int column, int row) {
  return (row * (board.columns + 1) + column) / 2;
}

}  // namespace slipstream
