#pragma once

#include <vector>

#include <Eigen/Core>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/bundle_adjustment.h"

namespace slipstream {

/// A calibration to start from, by OpenCV: camera and projector each by itself with two
/// coefficients of distortion, then both together, the lenses held. Throws Error where OpenCV finds
/// none.
BundleState first_guess(const std::vector<BoardView>& views,
                        const std::vector<Eigen::Vector3d>& printed, Size camera, Size projector);

/// The view without corners whose projector pixel is none of a plane's: more than `reach`
/// projector pixels from the homography that most of them agree on. They are set to NaN.
BoardView without_wrong_fringes(BoardView view, const std::vector<Eigen::Vector3d>& printed,
                                double reach = 8);

}  // namespace slipstream
