#pragma once

#include <optional>
#include <string>
#include <vector>

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

/// `view`: not used to calibrate `scanner`. `start`: approximate pose of its board. NaN if no
/// corner is lit.
ProjectorOffset projector_offset(const BoardView& view, const Scanner& scanner,
                                 const Eigen::Isometry3d& start, const BoardPlaces& places);

/// A calibration with a simple lens model and the nominal board: a start for further steps, and
/// enough to check that all poses are of one rig.
BundleState simple_calibration(const BoardViews& views, const BoardPlaces& printed, Size camera,
                               Size projector);

/// Throws Error with the likely cause if a pose does not fit the others, or none do. `state`: the
/// simple calibration of all poses.
void require_one_rig(const BoardViews& views, const BundleState& state, const BoardPlaces& printed);

/// The pose at which splitting the sequence into two rigs with the same lenses explains it best.
/// nullopt for fewer than six poses. `state`: a calibration of all poses.
std::optional<MovedRig> moved_rig(const BoardViews& views, const BundleState& state);

/// Problems common to the frames of all poses: a nonlinear response, blur of the projector or of
/// the camera. At most one diagnostic each.
std::vector<Finding> findings_of_frames(const BoardViews& views);

/// Why a pose does not fit the others, from its offset under their calibration.
Finding finding_of_pose(const BoardView& view, const ProjectorOffset& offset);

/// Camera and projector moved relative to each other between two poses, given by name.
Finding finding_of_moved_rig(const std::string& last, const std::string& first);

/// All diagnostics of a calibration.
std::vector<Finding> findings_about(const GeometryCalibration& calibration);

}  // namespace slipstream
