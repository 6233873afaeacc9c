#pragma once

#include "slipstream/geometry_calibration.h"

namespace slipstream {

/// Initial calibration by OpenCV: camera and projector separately with two distortion coefficients,
/// then both together with fixed lenses. Throws Error if OpenCV fails.
BundleState first_guess(const BoardViews& views, const BoardPlaces& printed, Size camera,
                        Size projector);

/// Sets projector pixels to NaN that lie more than 8 pixels from the homography on which most
/// corners of the view agree. Throws Error with the pose's name if the projector's view of the
/// board mirrors the camera's: a picture is mirrored, or the scans along x and y are swapped. Two
/// devices on the same side of the board differ by a rotation, never by a reflection.
BoardViews checked_views(BoardViews views, const BoardPlaces& printed);

/// Estimates a camera's lens without distortion: accurate enough for the tilt of boards.
Lens simple_lens(const BoardViews& views, const BoardPlaces& printed, Size camera);

/// Pose of the board (board to camera frame) from the camera's corners and a known lens.
Eigen::Isometry3d pose_before_camera(const BoardView& view, const Lens& camera,
                                     const BoardPlaces& printed);

/// All boards before a calibrated scanner, by the camera's corners.
BundleState boards_before(const Scanner& scanner, const BoardViews& views,
                          const BoardPlaces& printed);

}  // namespace slipstream
