#pragma once

#include <optional>
#include <string>

#include "geometry/pose_convention.h"
#include "slipstream/board_capture.h"
#include "slipstream/calibration_board.h"
#include "slipstream/image.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// The convention of the tables below.
PoseConvention board_table_convention();

/// The board in a picture of the camera alone, grey levels of 8 bits; nullopt if it shows no board.
std::optional<BoardView> board_in_picture(const std::string& name, const CalibrationBoard& board,
                                          const Image<float>& picture);

/// The boards' poses before a calibrated scanner, from the corners in the camera's picture and, if
/// known, in the projector's. Throws Error as verify_scanner.
PoseTable board_table(BoardViews views, const CalibrationBoard& board, const Scanner& scanner);

}  // namespace slipstream
