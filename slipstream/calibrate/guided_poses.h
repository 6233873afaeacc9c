#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "slipstream/calibrate/board_capture.h"
#include "slipstream/calibrate/pose_guide.h"
#include "slipstream/frames/scan_camera.h"

namespace slipstream {

/// How a person stands with the poses of a board, each time something was seen.
struct PoseProgress {
  const FringeFreePictures& pictures;
  const PoseVerdict& verdict;
  const PoseNeeds& needs;
  const std::vector<BoardView>& taken;
};

struct GuidedPosesSettings {
  int wanted = 0;  ///< see pose_needs
  BoardCaptureSettings capture{};
  std::function<void(const PoseProgress&)> told = {};  ///< called at every glimpse and pose
  std::function<bool()> ends = {};                     ///< asked again and again
};

/// Watches the board before the camera and takes a pose of it whenever it is good, until there are
/// enough or `ends` says so: scans along x and along y, into folders board01/x, board01/y,
/// board02/x and so on, as `calibrate geometry` reads them. A pose whose scans do not serve, by
/// board_capture, is refused and not kept; it is tried again once the board has moved. `camera`
/// gives the two scans of `sequence`, which is of no axis of its own. Returns the poses. Throws
/// Error where the folder holds something already, WorldError where it cannot be written.
std::vector<BoardView> take_guided_poses(ScanCamera& camera, const std::filesystem::path& folder,
                                         const CalibrationBoard& board, const Sequence& sequence,
                                         const GuidedPosesSettings& settings);

}  // namespace slipstream
