#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slipstream/calibration_board.h"
#include "slipstream/frame_set.h"
#include "slipstream/maps.h"

namespace slipstream {

/// The scene without fringes, over all frames of a pose, grey levels of 8 bits.
struct FringeFreePictures {
  Image<float> mean;
  Image<float> brightest;
};

/// Throws Error if the frames of the two scans differ in size.
FringeFreePictures fringe_free_pictures(const FrameViews& along_x, const FrameViews& along_y);

/// Corners of a board in a picture.
struct BoardCorners {
  std::vector<int> places;  ///< index of each in printed_places
  PixelPlaces pixels;
  std::string detector;  ///< name of the detector, as reported
};

/// Finds the board with subpixel accuracy: in the mean and then the brightest picture, by OpenCV's
/// sector-based detector and then by the classic one. Numbers the corners so that the board's X
/// points right in the picture and its Z away from the camera; a board that looks the same upside
/// down must be held within 90 degrees of upright. Returns nullopt if no board is visible. Throws
/// Error if the board has more corners than `board`.
std::optional<BoardCorners> find_board(const CalibrationBoard& board,
                                       const FringeFreePictures& pictures);

/// Corners across and down of any visible chessboard, larger number first, for error messages.
/// Returns nullopt if no chessboard is visible.
std::optional<Size> chessboard_size(const FringeFreePictures& pictures);

}  // namespace slipstream
