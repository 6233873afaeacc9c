#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/commands.h"
#include "app/output.h"
#include "base/page.h"
#include "slipstream/board_capture.h"
#include "slipstream/geometry_calibration.h"
#include "slipstream/scanner.h"

namespace slipstream::app {

/// Flags of the lens models and the files of a calibration.
struct CalibrationResultFlags {
  std::string camera_distortion = "auto", projector_distortion = "auto", print = "estimated";
  double print_deviation = 0.01;
  bool residual = false;
  std::string scanner;
  std::optional<std::string> report, compare;
};

/// Adds --output, --report and --compare.
void add_result_flags(const FlagGroup& command, CalibrationResultFlags& flags);

/// Adds --camera-distortion, --projector-distortion, --print, --print-deviation and --residual.
void add_model_flags(const FlagGroup& model, CalibrationResultFlags& flags);

/// Throws Error for an unknown model.
GeometryCalibrationSettings settings_from(const CalibrationResultFlags& flags);

/// The scanner of --compare; nullopt without it.
std::optional<Scanner> compared_scanner(const CalibrationResultFlags& flags);

nlohmann::json json_of_rms(const ReprojectionRms& rms);

/// A calibration and its input.
struct CalibrationResult {
  const GeometryCalibration& calibration;
  BoardPlaces places;  ///< nominal places of the board's corners
  std::string board;   ///< in words, see text_of(CalibrationBoard)
  std::vector<UnusedPose> unused;
  std::vector<Finding> findings;  ///< of the steps before the calibration
  Facts facts{};                  ///< about the poses, for the report
};

/// Writes the scanner file and, if requested, the report; prints the figures and diagnostics.
/// `other`: to compare with, without sizes if its file has none.
void write_calibration(const CalibrationResultFlags& flags, const CalibrationResult& result,
                       std::optional<Scanner> other, Output& output);

}  // namespace slipstream::app
