#pragma once

#include <opencv2/aruco/charuco.hpp>

#include "slipstream/calibrate/calibration_board.h"

namespace slipstream {

/// Markers that OpenCV has of each size.
inline constexpr int charuco_dictionary_size = 1000;

/// The board as OpenCV knows it, a square's side being 1.
inline cv::Ptr<cv::aruco::CharucoBoard> charuco_of(const CalibrationBoard& board) {
  constexpr int dictionaries[]{cv::aruco::DICT_4X4_1000, cv::aruco::DICT_5X5_1000,
                               cv::aruco::DICT_6X6_1000, cv::aruco::DICT_7X7_1000};
  return cv::aruco::CharucoBoard::create(
      board.columns + 1, board.rows + 1, 1, static_cast<float>(board.marker_side),
      cv::aruco::getPredefinedDictionary(dictionaries[board.marker_bits - 4]));
}

}  // namespace slipstream
