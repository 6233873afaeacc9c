#pragma once

#include "slipstream/calibrate/geometry_calibration.h"

namespace slipstream {

/// A calibration to start from, by OpenCV: camera and projector each by itself with two
/// coefficients of distortion, then both together, the lenses held. Throws Error where OpenCV finds
/// none.
BundleState first_guess(const BoardViews& views, const BoardPlaces& printed, Size camera,
                        Size projector);

/// The views without corners whose projector pixel is none of a plane's: more than 8 projector
/// pixels from the homography that most of them agree on. They are set to NaN. Throws Error, naming
/// the pose, where camera and projector see the board mirrored to each other: a projector or camera
/// picture is mirrored, or the scan along x was taken for that along y. Seen from the same side of
/// the board, two devices differ by a turn, never by a reflection.
BoardViews checked_views(BoardViews views, const BoardPlaces& printed);

/// A camera's lens, without distortion, by what it saw of boards: enough to tell how they lean.
Lens simple_lens(const BoardViews& views, const BoardPlaces& printed, Size camera);

/// Where the board of a view stands by what a camera of known lens sees of it: its frame to the
/// camera's.
Eigen::Isometry3d pose_before_camera(const BoardView& view, const Lens& camera,
                                     const BoardPlaces& printed);

/// Of a view before a scanner that it took no part in calibrating. `start`: about where its board
/// stands. NaN where no corner is lit.
ProjectorOffset projector_offset(const BoardView& view, const Scanner& scanner,
                                 const Eigen::Isometry3d& start, const BoardPlaces& places);

/// A calibration of a simple model, of a board as printed: good enough to build on, and to see
/// whether the poses are of one rig.
BundleState simple_calibration(const BoardViews& views, const BoardPlaces& printed, Size camera,
                               Size projector);

/// Throws Error, naming the likely cause, where a pose does not fit the others, or none fits any.
/// `state` is the simple calibration of them all.
void require_one_rig(const BoardViews& views, const BundleState& state, const BoardPlaces& printed);

/// The place in the sequence of poses at which two rigs of the same lenses explain them best. None
/// of less than six poses. `state` is a calibration of them all.
std::optional<MovedRig> moved_rig(const BoardViews& views, const BundleState& state);

/// What the frames of all poses have in common that spoils a calibration: a response that is not
/// linear, blur of the projector or of the camera. One finding each, whatever the number of poses.
std::vector<Finding> findings_of_frames(const BoardViews& views);

/// Why a pose may not fit the others, by how it stands before their scanner.
Finding finding_of_pose(const BoardView& view, const ProjectorOffset& offset);

/// Camera and projector moved against each other between two poses, by name.
Finding finding_of_moved_rig(const std::string& last, const std::string& first);

/// All that a person should know before trusting a calibration, the likely cause with each.
std::vector<Finding> findings_about(const GeometryCalibration& calibration);

}  // namespace slipstream
