#pragma once

#include <optional>
#include <string>

#include "app/board_captures.h"
#include "app/output.h"

namespace slipstream::app {

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
