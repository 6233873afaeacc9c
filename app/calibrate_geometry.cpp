#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/board_flags.h"
#include "app/board_scans.h"
#include "app/calibrate.h"
#include "app/progress.h"
#include "app/scan_flags.h"
#include "app/scan_input.h"
#include "slipstream/calibrate/board_capture.h"
#include "slipstream/calibrate/geometry_calibration.h"
#include "slipstream/calibrate/report.h"
#include "slipstream/error/error.h"
#include "slipstream/io/file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/scan_folder.h"
#include "slipstream/io/scanner_file.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

struct CalibrateGeometryFlags {
  std::string folder;
  BoardFlags board;
  ScanFlags scan;
  std::string first_axis = "x";
  std::vector<std::string> excluded;
  std::string camera_distortion = "auto";
  std::string projector_distortion = "auto";
  std::string print = "estimated";
  double print_deviation = 0.01;
  BoardCaptureSettings capture;
  std::string scanner;
  std::optional<std::string> report;
  std::optional<std::string> compare;
};

/// A number of coefficients, or none for "auto".
std::optional<int> coefficients_from(const std::string& text, const char* flag) {
  if (text == "auto") return std::nullopt;
  for (const int count : lens_models) {
    if (text == std::to_string(count)) return count;
  }
  throw Error(fmt::format("{} {} is not known; it is auto or one of {}", flag, text,
                          fmt::join(lens_models, ", ")));
}

GeometryCalibrationSettings settings_from(const CalibrateGeometryFlags& flags) {
  GeometryCalibrationSettings settings;
  settings.camera_coefficients = coefficients_from(flags.camera_distortion, "--camera-distortion");
  settings.projector_coefficients =
      coefficients_from(flags.projector_distortion, "--projector-distortion");
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

/// What all poses together gave.
struct Captures {
  std::vector<BoardView> views;
  std::vector<UnusedPose> unused;
  Size camera;
  Size projector;
};

void require_same(Size& known, Size size, const std::string& pose, const char* what) {
  if (known == Size{}) known = size;
  if (size == known) return;
  throw Error(
      fmt::format("{}: {} {}, but in the poses before {}; all poses must be of one camera "
                  "and projector",
                  pose, what, text_of(size), text_of(known)));
}

void capture(const BoardScans& scans, const CalibrationBoard& board,
             const BoardCaptureSettings& settings, Captures& captures, Output& output) {
  const auto read = [&](const ScanDescription& scan) {
    LoadedFrames loaded = read_frames(scan.frames, scan.bits);
    for (const std::string& warning : loaded.warnings) output.warn(warning);
    if (scan.projector == Size{}) {
      throw Error(fmt::format("{}: no projector size; give it with --projector", scans.name));
    }
    require_same(captures.camera, loaded.frames.size(), scans.name, "frames of");
    require_same(captures.projector, scan.projector, scans.name, "patterns for");
    return AxisScan{scan.strategy, std::move(loaded.frames), scan.light};
  };
  const AxisScan x = read(scans.x), y = read(scans.y);
  try {
    BoardCapture found = board_capture(scans.name, board, x, y, captures.projector, settings);
    output.say("{}: {}{}", scans.name, found.view ? "" : "left out: ", found.told);
    if (found.view) {
      captures.views.push_back(std::move(*found.view));
    } else {
      captures.unused.push_back({scans.name, found.told});
    }
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", scans.name, error.what()));
  }
}

Captures capture_all(const CalibrateGeometryFlags& flags, const CalibrationBoard& board,
                     Output& output) {
  const std::vector<BoardScans> poses =
      board_scans(flags.folder, flags.scan, axis_named(flags.first_axis));
  for (const std::string& name : flags.excluded) {
    const bool known = std::any_of(poses.begin(), poses.end(),
                                   [&](const BoardScans& pose) { return pose.name == name; });
    if (!known) {
      throw Error(fmt::format("--exclude {}: there is no such pose in {}", name, flags.folder));
    }
  }
  Captures captures;
  Progress progress("poses", static_cast<int>(poses.size()));
  for (const BoardScans& pose : poses) {
    if (std::find(flags.excluded.begin(), flags.excluded.end(), pose.name) !=
        flags.excluded.end()) {
      captures.unused.push_back({pose.name, "excluded"});
    } else {
      capture(pose, board, flags.capture, captures, output);
    }
    progress.advance();
  }
  if (captures.views.size() < fewest_poses) {
    const std::string first_reason =
        captures.unused.empty()
            ? ""
            : fmt::format(" ({}: {})", captures.unused[0].name, captures.unused[0].why);
    throw Error(fmt::format("{}: {} of {} poses can be used{}; at least {} are needed",
                            flags.folder, captures.views.size(), poses.size(), first_reason,
                            fewest_poses));
  }
  return captures;
}

nlohmann::json json_of(const ReprojectionRms& rms) {
  return {{"camera", rms.camera}, {"projector", rms.projector}, {"stereo", rms.stereo}};
}

nlohmann::json json_of(const std::vector<double>& values) {
  return values;
}

template <class Vector>
nlohmann::json json_of_vector(const Vector& vector) {
  return json_of(std::vector<double>(vector.begin(), vector.end()));
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

void add_quality(nlohmann::json& pose, const std::optional<BoardQuality>& quality) {
  pose["flatness_mm"] = quality ? nlohmann::json(quality->flatness) : nlohmann::json();
  pose["scale_error"] = quality ? nlohmann::json(quality->scale_error) : nlohmann::json();
}

nlohmann::json json_of_poses(const GeometryCalibration& calibration,
                             const std::vector<UnusedPose>& unused,
                             const std::optional<ScannerComparison>& comparison) {
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

nlohmann::json document(const CalibrateGeometryFlags& flags, const Captures& captures,
                        const GeometryCalibration& calibration,
                        const std::optional<ScannerComparison>& comparison) {
  const Scanner& scanner = calibration.state.scanner;
  const BoardQuality left_out = overall(left_out_qualities(calibration));
  nlohmann::json told = {
      {"scanner", flags.scanner},
      {"rms", json_of(calibration.rms)},
      {"flatness_mm", left_out.flatness},
      {"scale_error", left_out.scale_error},
      {"poses", json_of_poses(calibration, captures.unused, comparison)},
      {"camera", json_of(scanner.camera, calibration.deviation.camera, calibration.camera_lens,
                         calibration.covered_camera)},
      {"projector", json_of(scanner.projector, calibration.deviation.projector,
                            calibration.projector_lens, calibration.covered_projector)},
      {"baseline_mm", scanner.translation.norm()},
      {"rotation_deviation_rad", json_of_vector(calibration.deviation.rotation)},
      {"translation_deviation_mm", json_of_vector(calibration.deviation.translation)},
      {"largest_tilt_rad", calibration.largest_tilt},
      {"warnings", calibration.warnings}};
  if (comparison) {
    const BoardQuality compared = overall(comparison->poses);
    told["compared"] = {{"scanner", comparison->name},
                        {"flatness_mm", compared.flatness},
                        {"scale_error", compared.scale_error}};
  }
  if (flags.report) told["report"] = *flags.report;
  return told;
}

void tell(const CalibrateGeometryFlags& flags, const GeometryCalibration& calibration,
          const std::optional<ScannerComparison>& comparison, Output& output) {
  const auto& [camera, projector, stereo] = calibration.rms;
  output.say("RMS: camera {:.3f} px, projector {:.3f} px, stereo {:.3f} px", camera, projector,
             stereo);
  const BoardQuality left_out = overall(left_out_qualities(calibration));
  output.say(
      "each pose measured with a calibration of the others: flat to {:.4f} mm, scale "
      "error {:.3f} %",
      left_out.flatness, 100 * left_out.scale_error);
  if (comparison) {
    const BoardQuality compared = overall(comparison->poses);
    output.say("measured with {}: flat to {:.4f} mm, scale error {:.3f} %", comparison->name,
               compared.flatness, 100 * compared.scale_error);
  }
  output.say("lens models: camera {}, projector {}",
             name_of_lens_model(calibration.camera_lens.coefficients),
             name_of_lens_model(calibration.projector_lens.coefficients));
  for (const std::string& warning : calibration.warnings) output.warn(warning);
  output.say("the scanner file is {}", flags.scanner);
  if (flags.report)
    output.say("the report is {}", (fs::path(*flags.report) / "report.md").string());
}

void calibrate(const CalibrateGeometryFlags& flags, Output& output) {
  const CalibrationBoard board = board_from(flags.board);
  const GeometryCalibrationSettings settings = settings_from(flags);
  std::optional<Scanner> other;
  if (flags.compare) other = read_scanner(*flags.compare);
  const Captures captures = capture_all(flags, board, output);
  if (other) other = completed(*other, *flags.compare, captures.camera, captures.projector);
  const GeometryCalibration calibration =
      calibrate_geometry(captures.views, board, captures.camera, captures.projector, settings);

  std::optional<ScannerComparison> comparison;
  if (other) {
    comparison = compared_with(*other, fs::path(*flags.compare).filename().string(),
                               calibration.views, board);
  }
  if (flags.report) {
    write_calibration_report(*flags.report, {calibration, calibration.views, captures.unused, board,
                                             comparison ? &*comparison : nullptr});
  }
  const std::vector<std::string> kept = replace_geometry(flags.scanner, calibration.state.scanner);
  output.document = document(flags, captures, calibration, comparison);
  tell(flags, calibration, comparison, output);
  if (!kept.empty()) {
    output.say("kept of the file that was there: {}", fmt::join(kept, ", "));
  }
}

void add_model_flags(CLI::App& command, CalibrateGeometryFlags& flags) {
  const std::string group = "Model";
  const std::string models = fmt::format("coefficients of its lens: auto, or {} in OpenCV's order",
                                         fmt::join(lens_models, ", "));
  command.add_option("--camera-distortion", flags.camera_distortion, models)
      ->capture_default_str()
      ->group(group);
  command.add_option("--projector-distortion", flags.projector_distortion, models)
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--print", flags.print,
                  "the board's corners: estimated (near where printed) or exact")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--print-deviation", flags.print_deviation,
                  "standard deviation of a printed corner, in spacings")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--min-modulation", flags.capture.minimum_modulation,
                  "least modulation of a pixel whose phase is used, grey levels of 255")
      ->capture_default_str()
      ->group(group);
  command
      .add_option("--neighbourhood", flags.capture.neighbourhood,
                  "radius about a corner in which phase is used, in distances to the next corner")
      ->capture_default_str()
      ->group(group);
}

}  // namespace

void add_calibrate_geometry(CLI::App& calibrate_command, SharedFlags& shared, Command& chosen) {
  CLI::App* command = calibrate_command.add_subcommand(
      "geometry", "scans of a board in several poses to a scanner file");
  const auto flags = std::make_shared<CalibrateGeometryFlags>();
  command
      ->add_option("folder", flags->folder,
                   "holds a folder for each pose: scan folders x and y, or the pictures of both")
      ->required();
  command->add_option("-o,--output", flags->scanner, "the scanner file: .yaml or .xml")->required();
  command->add_option("--report", flags->report, "a folder for a report with pictures");
  command->add_option("--compare", flags->compare, "a scanner file to hold beside the result");
  command->add_option("--exclude", flags->excluded, "poses to leave out, by name");
  command
      ->add_option("--first-axis", flags->first_axis,
                   "where both scans lie in one folder: x or y, whose pictures come first")
      ->capture_default_str();
  add_board_flags(*command, flags->board);
  add_model_flags(*command, *flags);
  add_scan_flags(*command, flags->scan);
  command->remove_option(command->get_option("--axis"));
  add_shared_flags(*command, shared);
  command->footer(
      "Example:\n  slipstream calibrate geometry poses --board chessboard --corners 13x9 --spacing "
      "10 --strategy dual-frequency --steps 3 --high 16 --low 1 --projector 1824x1140 -o "
      "scanner.yaml --report report");
  command->callback(
      [flags, &chosen] { chosen = [flags](Output& output) { calibrate(*flags, output); }; });
}

}  // namespace slipstream::app
