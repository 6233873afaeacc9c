#pragma once

#include <vector>

#include "slipstream/calibration_board.h"
#include "slipstream/frame_set.h"
#include "slipstream/maps.h"

namespace slipstream {

/// The projector pixel that lights each camera pixel.
struct ProjectorMap {
  Image<double> x;
  Image<double> y;
  Image<double> weight;  ///< inverse variance: B^2; 0 if unreliable
};

/// Combines a scan along each axis. A pixel is reliable if it is unsaturated and its modulation is
/// at least `minimum_modulation` (grey levels of an 8-bit camera) in both scans.
ProjectorMap projector_map(const FrameViews& frames_x, const BasicMaps<double>& along_x,
                           const FrameViews& frames_y, const BasicMaps<double>& along_y,
                           Size projector, double minimum_modulation);

/// A corner in the projector's picture.
struct ProjectorCorner {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d slope;  ///< d pixel / d camera pixel
};

/// Projector pixels of the camera's `corners` (pixels): a homography from camera to projector is
/// fitted robustly to the reliable pixels within a radius of each corner (Moreno and Taubin 2012,
/// "Simple, accurate, and robust projector-camera calibration"). The radius is `share` of the
/// distance to the next corner. NaN if too few pixels are reliable.
std::vector<ProjectorCorner> projector_corners(const ProjectorMap& map, const PixelPlaces& corners,
                                               double share);

/// Distance from corner i to the nearest other corner, pixels.
double distance_to_next(const PixelPlaces& corners, std::size_t i);

}  // namespace slipstream
