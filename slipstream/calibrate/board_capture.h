#pragma once

#include <functional>

#include "slipstream/calibrate/board_corners.h"
#include "slipstream/calibrate/board_view.h"
#include "slipstream/codes/response.h"

namespace slipstream {

struct BoardCaptureSettings {
  /// Grey levels of 8 bits, 0 to 255; below it a pixel's phase is not used.
  double minimum_modulation = 5;
  double neighbourhood = 0.7;  ///< `share` of projector_corners, above 0, at most 10
  std::optional<MeasuredResponse> response{};  ///< for which phases are corrected
};

/// What a pose's frames gave.
struct BoardCapture {
  std::optional<BoardView> view;    ///< none where the pose is of no use
  std::string told;                 ///< who found the board, or why there is none
  std::vector<Finding> findings{};  ///< of its frames; what is wrong refuses the pose
};

/// Finds the board in a pose's frames and, from a scan along each axis, the projector pixel of each
/// corner. Frames that have slipped are put in order first. Throws Error where scans are not of
/// their strategy, differ in size or in the projector's, give no coordinate or need the ambient
/// light for it, the board is larger than said, or a setting is out of range.
BoardCapture board_capture(const std::string& name, const CalibrationBoard& board, Scan along_x,
                           Scan along_y, const BoardCaptureSettings& settings = {});

/// A pose that took no part.
struct UnusedPose {
  std::string name;
  std::string why;
};

/// What all poses of a board together gave.
struct PoseCaptures {
  BoardViews views{};
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
