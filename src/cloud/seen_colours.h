#pragma once

#include <Eigen/Geometry>

#include "slipstream/cloud.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Colours of a cloud's points, one for each pixel, from a picture of another camera: each point
/// has the colour of the pixel nearest to its image. Pixels without a point are black, and points
/// that the camera does not see, outside its picture or behind others. `pose`: from the cloud's
/// frame to the camera's, mm.
Image<Colour> colours_seen_by(const Cloud& cloud, const Image<Colour>& picture, const Lens& lens,
                              const Eigen::Isometry3d& pose);

}  // namespace slipstream
