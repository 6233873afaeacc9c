#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/board_flags.h"
#include "app/calibration_result.h"
#include "slipstream/board_capture.h"
#include "slipstream/scan_files.h"

namespace slipstream::app {

/// Folders of board scans and how to read them.
struct BoardCaptureFlags {
  std::string folder;
  BoardFlags board;
  ScanChanges scan;
  std::string first_axis = "x";
  std::vector<std::string> excluded;
  BoardCaptureSettings capture;
};

/// The flags of `calibrate geometry`.
struct CalibrateGeometryFlags {
  BoardCaptureFlags boards;
  CalibrationResultFlags result;
  std::optional<std::string> measured;
  std::optional<std::string> points;      ///< file to write the corners to
  std::vector<std::string> more_cameras;  ///< folders of further cameras' poses
};

/// Finds the board in every pose and reports each. Corrects phases for the response if it is known.
PoseCaptures captured_boards(const BoardCaptureFlags& flags, const CalibrationBoard& board,
                             const std::optional<MeasuredResponse>& response, Output& output);

/// Calibrates from board scans in several poses; writes and reports the scanner file and the
/// report. The document's `verdict` is the report's.
void calibrate_boards(const CalibrateGeometryFlags& flags, Output& output);

}  // namespace slipstream::app
