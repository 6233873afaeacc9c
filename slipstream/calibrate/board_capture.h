#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slipstream/calibrate/board_corners.h"
#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/check/finding.h"
#include "slipstream/codes/response.h"
#include "slipstream/geometry/scan.h"

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

}  // namespace slipstream
