#pragma once

#include <optional>
#include <string>

#include "slipstream/calibrate/board_corners.h"
#include "slipstream/calibrate/board_view.h"
#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/capture/frame_set.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream {

/// The frames of a board under patterns along one axis.
struct AxisScan {
  Strategy strategy;
  FrameSet frames;
};

struct BoardCaptureSettings {
  double minimum_modulation = 5;  ///< grey levels of 8 bits; below it a pixel's phase is not used
  double neighbourhood = 0.7;     ///< see projector_corners
};

/// What a pose's frames gave.
struct BoardCapture {
  std::optional<BoardView> view;  ///< none where the pose is of no use
  std::string told;               ///< who found the board, or why there is none
};

/// Finds the board in a pose's frames and, from both scans, the projector pixel of each corner.
/// Throws Error where scans are not of that strategy, differ in size or give no coordinate, or the
/// board is larger than said.
BoardCapture board_capture(const std::string& name, const CalibrationBoard& board,
                           const AxisScan& along_x, const AxisScan& along_y, Size projector,
                           const BoardCaptureSettings& settings = {});

}  // namespace slipstream
