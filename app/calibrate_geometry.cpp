#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "app/board_flags.h"
#include "app/commands.h"
#include "app/findings.h"
#include "slipstream/base/error.h"
#include "slipstream/calibrate/calibration_board.h"
#include "slipstream/calibrate/geometry_calibration.h"
#include "slipstream/calibrate/report.h"
#include "slipstream/io/scanner_file.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

GeometryCalibrationSettings settings_from(const CalibrateGeometryFlags& flags) {
  GeometryCalibrationSettings settings;
  settings.camera_coefficients = lens_model_named(flags.camera_distortion, "--camera-distortion");
  settings.projector_coefficients =
      lens_model_named(flags.projector_distortion, "--projector-distortion");
  if (flags.print != "exact" && flags.print != "estimated") {
    throw Error(fmt::format("--print {} is not known; it is estimated or exact", flags.print));
  }
  if (!(flags.print_deviation > 0 && flags.print_deviation < 1)) {
    throw Error(fmt::format("--print-deviation {} is out of range; more than 0, less than 1",
                            flags.print_deviation));
  }
  settings.print_deviation =
      flags.print == "exact" ? std::nullopt : std::optional(flags.print_deviation);
  return settings;
}

/// What the scanner file to write knows already.
std::optional<MeasuredResponse> response_in(const fs::path& scanner) {
  if (!fs::exists(scanner)) return std::nullopt;
  return read_photometric_calibration(scanner).response;
}

std::vector<Finding> measured_findings(const CalibrateGeometryFlags& flags,
                                       const CalibrationBoard& board) {
  if (!flags.measured) return {};
  const std::vector<double> lengths = lengths_from(*flags.measured, "--measured");
  if (lengths.size() != 2) {
    throw Error(
        fmt::format("--measured {}: two lengths are wanted, of a row and of a column, as "
                    "121.9x80.3",
                    *flags.measured));
  }
  return findings_of_ruler(board, {lengths[0], lengths[1]});
}

nlohmann::json json_of(const ReprojectionRms& rms) {
  return {{"camera", rms.camera}, {"projector", rms.projector}, {"stereo", rms.stereo}};
}

template <class Vector>
nlohmann::json json_of_vector(const Vector& vector) {
  return std::vector<double>(vector.begin(), vector.end());
}

nlohmann::json json_of(const Lens& lens, const LensDeviation& deviation, const LensChoice& choice,
                       double covered) {
  const Eigen::Matrix3d& K = lens.intrinsic;
  nlohmann::json scores = nlohmann::json::array();
  for (const LensModelScore& score : choice.scores) {
    scores.push_back({{"coefficients", score.coefficients}, {"left_out_error", score.error}});
  }
  return {{"focal_px", {K(0, 0), K(1, 1)}},
          {"focal_deviation_px", json_of_vector(deviation.focal)},
          {"principal_point_px", {K(0, 2), K(1, 2)}},
          {"principal_point_deviation_px", json_of_vector(deviation.principal_point)},
          {"distortion", json_of_vector(lens.distortion.coefficients)},
          {"distortion_deviation", json_of_vector(deviation.coefficients)},
          {"distortion_coefficients", choice.coefficients},
          {"distortion_models", scores},
          {"covered_share", covered}};
}

void add_quality(nlohmann::json& told, const std::optional<BoardQuality>& quality) {
  const auto add = [&](const char* name, double BoardQuality::*figure) {
    told[name] = quality ? nlohmann::json((*quality).*figure) : nlohmann::json();
  };
  add("flatness_mm", &BoardQuality::flatness);
  add("distance_error_mm", &BoardQuality::distance_error);
  add("scale_error", &BoardQuality::scale_error);
}

nlohmann::json json_of_poses(const CalibrationReport& report) {
  const auto& [calibration, unused, board, comparison, findings] = report;
  nlohmann::json poses = nlohmann::json::array();
  for (std::size_t i = 0; i < calibration.poses.size(); ++i) {
    const CalibratedPose& pose = calibration.poses[i];
    nlohmann::json told = {{"name", pose.name},
                           {"used", true},
                           {"rms", json_of(pose.rms)},
                           {"corners", pose.corners},
                           {"lit_corners", pose.lit}};
    add_quality(told, pose.left_out);
    if (comparison) add_quality(told["compared"], comparison->poses[i]);
    poses.push_back(told);
  }
  for (const UnusedPose& pose : unused) {
    poses.push_back({{"name", pose.name}, {"used", false}, {"reason", pose.why}});
  }
  std::sort(poses.begin(), poses.end(), [](const auto& a, const auto& b) {
    return before_in_order(a["name"].template get<std::string>(),
                           b["name"].template get<std::string>());
  });
  return poses;
}

nlohmann::json document(const CalibrateGeometryFlags& flags, const CalibrationReport& report) {
  const GeometryCalibration& calibration = report.calibration;
  const Scanner& scanner = calibration.state.scanner;
  nlohmann::json told = {
      {"scanner", flags.scanner},
      {"rms", json_of(calibration.rms)},
      {"poses", json_of_poses(report)},
      {"camera", json_of(scanner.camera, calibration.deviation.camera, calibration.camera_lens,
                         calibration.covered_camera)},
      {"projector", json_of(scanner.projector, calibration.deviation.projector,
                            calibration.projector_lens, calibration.covered_projector)},
      {"baseline_mm", scanner.translation.norm()},
      {"rotation_deviation_rad", json_of_vector(calibration.deviation.rotation)},
      {"translation_deviation_mm", json_of_vector(calibration.deviation.translation)},
      {"largest_tilt_rad", calibration.largest_tilt},
      {"depths_mm", {scanner.calibrated_depths->nearest, scanner.calibrated_depths->farthest}}};
  add_quality(told, overall(left_out_qualities(calibration)));
  told["findings"] = app::json_of(report.findings);
  if (report.comparison != nullptr) {
    told["compared"] = {{"scanner", report.comparison->name}};
    add_quality(told["compared"], overall(report.comparison->poses));
  }
  if (flags.report) told["report"] = *flags.report;
  return told;
}

}  // namespace

void calibrate_boards(const CalibrateGeometryFlags& flags, Output& output) {
  const CalibrationBoard board = board_from(flags.boards.board);
  const GeometryCalibrationSettings settings = settings_from(flags);
  std::vector<Finding> findings = measured_findings(flags, board);
  std::optional<Scanner> other;
  if (flags.compare) other = read_scanner(*flags.compare);
  const PoseCaptures captures =
      captured_boards(flags.boards, board, response_in(flags.scanner), output);
  require_enough_poses(captures, flags.boards.folder);
  if (other) other = completed(*other, *flags.compare, captures.camera, captures.projector);
  const GeometryCalibration calibration =
      calibrate_geometry(captures.views, board, captures.camera, captures.projector, settings);

  std::optional<ScannerComparison> comparison;
  if (other) {
    comparison = compared_with(*other, fs::path(*flags.compare).filename().string(),
                               calibration.views, board);
  }
  for (const auto* more : {&captures.findings, &calibration.findings}) {
    findings.insert(findings.end(), more->begin(), more->end());
  }
  const CalibrationReport report{calibration, captures.unused, board,
                                 comparison ? &*comparison : nullptr, findings};
  if (flags.report) write_calibration_report(*flags.report, report);
  const std::vector<std::string> kept = replace_geometry(flags.scanner, calibration.state.scanner);
  output.document = document(flags, report);
  output.say("{}", text_of(report));
  warn_of(findings, output);
  output.say("the scanner file is {}", flags.scanner);
  if (flags.report) {
    output.say("the report is {}", (fs::path(*flags.report) / "report.md").string());
  }
  if (!kept.empty()) {
    output.say("kept of the file that was there: {}", fmt::join(kept, ", "));
  }
}

namespace {

void add_model_flags(CLI::App& command, CalibrateGeometryFlags& flags) {
  const FlagGroup group{command, "Model"};
  const std::string models = fmt::format("coefficients of its lens: auto, or {} in OpenCV's order",
                                         fmt::join(lens_models, ", "));
  group.add("--camera-distortion", flags.camera_distortion, models);
  group.add("--projector-distortion", flags.projector_distortion, models);
  group.add("--print", flags.print, "the board's corners: estimated (near where printed) or exact");
  group.add("--print-deviation", flags.print_deviation,
            "standard deviation of a printed corner, in spacings");
}

}  // namespace

void add_calibrate_geometry(CLI::App& calibrate_command, Command& chosen) {
  const auto [command, flags] = add_command(calibrate_command, chosen, calibrate_boards, "geometry",
                                            "scans of a board in several poses to a scanner file");
  command.add_scanner_output("-o,--output", flags.scanner, "the scanner file: .yaml or .xml")
      ->required();
  command.add("--report", flags.report, "a folder for a report with pictures");
  command.add_file("--compare", flags.compare, "a scanner file to hold beside the result");
  command.add("--measured", flags.measured,
              "mm by a ruler on the print, from the first to the last corner: row x column");
  add_board_capture_flags(command, flags.boards);
  add_model_flags(command.app, flags);
  command.app.footer(
      "Example:\n  slipstream calibrate geometry poses --board chessboard --corners 13x9 --spacing "
      "10 --strategy dual-frequency --steps 3 --high 16 --low 1 --projector 1824x1140 -o "
      "scanner.yaml --report report");
}

}  // namespace slipstream::app
