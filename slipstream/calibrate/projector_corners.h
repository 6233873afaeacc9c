#pragma once

#include <vector>

#include <Eigen/Core>

#include "slipstream/base/image.h"
#include "slipstream/decode/maps.h"
#include "slipstream/frames/frame_views.h"

namespace slipstream {

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
std::vector<ProjectorCorner> projector_corners(const ProjectorMap& map,
                                               const std::vector<Eigen::Vector2d>& corners,
                                               double share);

/// From a corner to the nearest other, pixels.
double distance_to_next(const std::vector<Eigen::Vector2d>& corners, std::size_t i);

}  // namespace slipstream
