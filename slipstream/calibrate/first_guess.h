#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/bundle_adjustment.h"

namespace slipstream {

/// A calibration to start from, by OpenCV: camera and projector each by itself with two
/// coefficients of distortion, then both together, the lenses held. Throws Error where OpenCV finds
/// none.
BundleState first_guess(const std::vector<BoardView>& views,
                        const std::vector<Eigen::Vector3d>& printed, Size camera, Size projector);

/// The views without corners whose projector pixel is none of a plane's: more than 8 projector
/// pixels from the homography that most of them agree on. They are set to NaN. Throws Error, naming
/// the pose, where camera and projector see the board mirrored to each other: a projector or camera
/// picture is mirrored, or the scan along x was taken for that along y. Seen from the same side of
/// the board, two devices differ by a turn, never by a reflection.
std::vector<BoardView> checked_views(std::vector<BoardView> views,
                                     const std::vector<Eigen::Vector3d>& printed);

/// A camera's lens, without distortion, by what it saw of boards: enough to tell how they lean.
Lens simple_lens(const std::vector<BoardView>& views, const std::vector<Eigen::Vector3d>& printed,
                 Size camera);

/// Where the board of a view stands by what a camera of known lens sees of it: its frame to the
/// camera's.
Eigen::Isometry3d pose_before_camera(const BoardView& view, const Lens& camera,
                                     const std::vector<Eigen::Vector3d>& printed);

}  // namespace slipstream
