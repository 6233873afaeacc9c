#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "app/board_flags.h"
#include "app/flag_group.h"
#include "app/output.h"
#include "app/scan_flags.h"
#include "slipstream/calibrate/pose_captures.h"
#include "slipstream/codes/response.h"

namespace slipstream::app {

/// Where scans of a board are and what they are.
struct BoardCaptureFlags {
  std::string folder;
  BoardFlags board;
  ScanFlags scan;
  std::string first_axis = "x";
  std::vector<std::string> excluded;
  BoardCaptureSettings capture;
};

/// Adds the folder, --exclude, --first-axis, --min-modulation, --neighbourhood and the flags of
/// board and patterns.
void add_board_capture_flags(const FlagGroup& command, BoardCaptureFlags& flags);

/// Finds the board in all poses and tells of each. Phases are corrected for the response, where
/// there is one.
PoseCaptures captured_boards(const BoardCaptureFlags& flags, const CalibrationBoard& board,
                             const std::optional<MeasuredResponse>& response, Output& output);

}  // namespace slipstream::app
