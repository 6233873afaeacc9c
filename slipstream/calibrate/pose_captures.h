#pragma once

#include <functional>
#include <string>
#include <vector>

#include "slipstream/calibrate/board_capture.h"
#include "slipstream/calibrate/board_scans.h"
#include "slipstream/calibrate/report.h"

namespace slipstream {

/// What all poses of a board together gave.
struct PoseCaptures {
  std::vector<BoardView> views{};
  std::vector<UnusedPose> unused{};
  Size camera{};
  Size projector{};
  std::vector<std::string> warnings{};  ///< of reading the frames
  std::vector<Finding> findings{};      ///< of the poses' frames
};

/// Finds the board in all poses but the `excluded`, by name. `told` is called after each with what
/// it gave in words, with nothing where it was excluded. Throws Error, naming the pose, where its
/// frames cannot be read, do not serve, or are of another camera or projector than those before,
/// and for an excluded name that no pose in the folder has.
PoseCaptures capture_poses(const std::string& folder, const std::vector<BoardScans>& poses,
                           const std::vector<std::string>& excluded, const CalibrationBoard& board,
                           const BoardCaptureSettings& settings,
                           const std::function<void(const std::string& words)>& told);

/// Throws Error, naming the folder, where fewer poses can be used than a calibration needs.
void require_enough_poses(const PoseCaptures& captures, const std::string& folder);

}  // namespace slipstream
