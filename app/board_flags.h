#pragma once

#include <optional>
#include <string>

#include <CLI/App.hpp>

#include "slipstream/calibrate/calibration_board.h"

namespace slipstream::app {

/// The flags that say what the calibration board is.
struct BoardFlags {
  std::string kind = "chessboard";
  std::string corners = "13x9";
  double spacing = 10;
  std::optional<double> circle_diameter;  ///< mm
  std::optional<double> marker_side;      ///< mm
  std::string dictionary = "4x4";
};

/// Adds --board, --corners, --spacing, --circle-diameter, --marker-side and --dictionary.
void add_board_flags(CLI::App& subcommand, BoardFlags& flags);

/// The board that the flags say. Throws Error, naming the flag, where there is none.
CalibrationBoard board_from(const BoardFlags& flags);

}  // namespace slipstream::app
