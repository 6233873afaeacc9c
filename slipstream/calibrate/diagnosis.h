#pragma once

#include <string>
#include <vector>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/projector_offset.h"
#include "slipstream/check/finding.h"

namespace slipstream {

struct GeometryCalibration;

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
