#pragma once

#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>

#include "slipstream/calibrate/calibration_board.h"

namespace slipstream::app {

/// The flags that say what the calibration board is.
struct BoardFlags {
  std::string kind = "chessboard";
  std::string corners = "13x9";
  std::optional<std::string> spacing;     ///< mm: "10", or of a stretched print "10x10.1"
  std::optional<double> circle_diameter;  ///< mm
  std::optional<double> marker_side;      ///< mm
  std::string dictionary = "4x4";
};

/// Adds --board, --corners, --spacing, --circle-diameter, --marker-side and --dictionary.
void add_board_flags(CLI::App& subcommand, BoardFlags& flags);

/// The board that the flags say. Throws Error, naming the flag, where there is none or no spacing
/// is given.
CalibrationBoard board_from(const BoardFlags& flags);

/// "121.9x80.3" or "121.9": one length or two, mm. Throws Error, naming the flag, for anything
/// else.
std::vector<double> lengths_from(const std::string& text, const std::string& flag);

}  // namespace slipstream::app
