#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "app/commands.h"
#include "app/output.h"
#include "slipstream/calibrate/board_capture.h"
#include "slipstream/codes/response.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/simulate/scene.h"

namespace slipstream::app {

/// The flags that say what the calibration board is.
struct BoardFlags {
  CalibrationBoard board;
  bool has_spacing = false;
};

/// Adds --board, --corners, --spacing, --circle-diameter, --marker-side and --dictionary.
void add_board_flags(CLI::App& subcommand, BoardFlags& flags);

/// The board that the flags say. Throws Error where it cannot be or no spacing is given.
CalibrationBoard board_from(const BoardFlags& flags);

/// "121.9x80.3" or "121.9": one length or two, mm. Throws Error, naming the flag, for other text.
std::vector<double> lengths_from(const std::string& text, const std::string& flag);

/// Folders of board scans, and the kind of each.
struct BoardCaptureFlags {
  std::string folder;
  BoardFlags board;
  ScanChanges scan;
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

/// The board as a sheet in the scene, its printing as fine as a camera could ever see.
Body sheet_of(const CalibrationBoard& board, const Scanner& scanner);

/// `count` poses of the board. Throws Error if --boards is out of range.
std::vector<Eigen::Isometry3d> poses_of(const Body& sheet, int count, const Scanner& scanner);

/// The flags of `calibrate geometry`.
struct CalibrateGeometryFlags {
  BoardCaptureFlags boards;
  std::string camera_distortion = "auto";
  std::string projector_distortion = "auto";
  std::string print = "estimated";
  double print_deviation = 0.01;
  std::string scanner;
  std::optional<std::string> report;
  std::optional<std::string> compare;
  std::optional<std::string> measured;
};

/// Scans of a board in several poses to a scanner file: writes it and the report, tells both.
void calibrate_boards(const CalibrateGeometryFlags& flags, Output& output);

}  // namespace slipstream::app
