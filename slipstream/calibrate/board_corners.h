#pragma once

#include <string>

#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/decode/maps.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// A scene without the fringes on it: over all frames of a pose, grey levels of 8 bits.
struct FringeFreePictures {
  Image<float> mean;
  Image<float> brightest;
};

/// Throws Error when the frames of the two scans differ in size.
FringeFreePictures fringe_free_pictures(const FrameViews& along_x, const FrameViews& along_y);

/// Corners of a board in a picture.
struct BoardCorners {
  std::vector<int> places;  ///< which of printed_places each is
  PixelPlaces pixels;
  std::string detector;  ///< what found them, as reported
};

/// Finds the board to a fraction of a pixel: in the mean and then the brightest picture, by
/// OpenCV's sector-based detector and then by the classic one. Corners are numbered so that the
/// board's X runs to the right in the picture and its Z away from the camera; a board that looks
/// the same upside down must be held within 90 degrees of upright. Nothing where no board is seen.
/// Throws Error where the board goes on beyond the corners that were asked for.
std::optional<BoardCorners> find_board(const CalibrationBoard& board,
                                       const FringeFreePictures& pictures);

/// Corners across and down of whatever chessboard is seen, the larger number first: to tell a
/// person what is wrong. Nothing where there is none.
std::optional<Size> chessboard_size(const FringeFreePictures& pictures);

/// The projector pixel that lights each camera pixel.
struct ProjectorMap {
  Image<double> x;
  Image<double> y;
  Image<double> weight;  ///< of the pixel, as its variance is: B^2; 0 where it is not reliable
};

/// From a scan along each axis. A pixel is reliable that neither scan saturates and whose
/// modulation is at least `minimum_modulation` (grey levels of an 8-bit camera) in both.
ProjectorMap projector_map(const FrameViews& frames_x, const BasicMaps<double>& along_x,
                           const FrameViews& frames_y, const BasicMaps<double>& along_y,
                           Size projector, double minimum_modulation);

/// A corner in the projector's picture.
struct ProjectorCorner {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d slope;  ///< d pixel / d camera pixel
};

/// Where the projector would see what the camera sees at `corners` (pixels): the homography from
/// camera to projector fitted, robustly, to the reliable pixels within a radius of each corner
/// (Moreno and Taubin 2012, "Simple, accurate, and robust projector-camera calibration"). The
/// radius is `share` of the distance to the next corner. NaN where too few pixels are reliable.
std::vector<ProjectorCorner> projector_corners(const ProjectorMap& map, const PixelPlaces& corners,
                                               double share);

/// From a corner to the nearest other, pixels.
double distance_to_next(const PixelPlaces& corners, std::size_t i);

}  // namespace slipstream
