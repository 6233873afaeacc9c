#pragma once

#include <string>
#include <vector>

#include "slipstream/geometry_calibration.h"

namespace slipstream {

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
