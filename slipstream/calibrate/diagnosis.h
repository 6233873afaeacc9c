#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/bundle_adjustment.h"
#include "slipstream/calibrate/geometry_calibration.h"
#include "slipstream/check/finding.h"

namespace slipstream {

/// Of a view before a scanner that it took no part in calibrating. `start`: about where its board
/// stands. NaN where no corner is lit.
ProjectorOffset projector_offset(const BoardView& view, const Scanner& scanner,
                                 const Eigen::Isometry3d& start,
                                 const std::vector<Eigen::Vector3d>& places);

/// A calibration of a simple model, of a board as printed: good enough to build on, and to see
/// whether the poses are of one rig.
BundleState simple_calibration(const std::vector<BoardView>& views,
                               const std::vector<Eigen::Vector3d>& printed, Size camera,
                               Size projector);

/// Throws Error, naming the likely cause, where a pose does not fit the others, or none fits any.
/// `state` is the simple calibration of them all.
void require_one_rig(const std::vector<BoardView>& views, const BundleState& state,
                     const std::vector<Eigen::Vector3d>& printed);

/// The place in the sequence of poses at which two rigs of the same lenses explain them best. None
/// of less than six poses. `state` is a calibration of them all.
std::optional<MovedRig> moved_rig(const std::vector<BoardView>& views, const BundleState& state);

/// What the frames of all poses have in common that spoils a calibration: a response that is not
/// linear, blur of the projector or of the camera. One finding each, whatever the number of poses.
std::vector<Finding> findings_of_frames(const std::vector<BoardView>& views);

/// Why a pose may not fit the others, by how it stands before their scanner.
Finding finding_of_pose(const BoardView& view, const ProjectorOffset& offset);

/// Camera and projector moved against each other between two poses, by name.
Finding finding_of_moved_rig(const std::string& last, const std::string& first);

/// All that a person should know before trusting a calibration, the likely cause with each.
std::vector<Finding> findings_about(const GeometryCalibration& calibration);

}  // namespace slipstream
