#include "app/calibrate_boards.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "app/calibrate_photometry.h"
#include "app/flag_names.h"
#include "app/phase_maps.h"
#include "app/report_facts.h"
#include "app/scan_flags.h"
#include "calibrate/board_view.h"
#include "calibrate/report.h"
#include "io/image_file.h"
#include "io/print_file.h"
#include "io/scan_pictures.h"
#include "slipstream/scan_files.h"

namespace slipstream::app {
namespace {

struct CalibrateBoardFlags {
  BoardFlags board;
  std::string file;
  double dots_per_inch = 600;
};

void write_board(const CalibrateBoardFlags& flags, Output& output) {
  const CalibrationBoard board = board_from(flags.board);
  constexpr double mm_per_inch = 25.4;
  require_in_range(flags.dots_per_inch > 0 && flags.dots_per_inch <= 10000, "--dpi",
                   flags.dots_per_inch, "more than 0, at most 10000");

  // A whole number of pixels per spacing keeps edges sharp; the page size in mm sets the scale.
  const int pixels_per_spacing =
      static_cast<int>(std::lround(board.spacing / mm_per_inch * flags.dots_per_inch));
  const Image<std::uint8_t> picture = draw_board(board, pixels_per_spacing);
  const double mm_per_pixel = board.spacing / pixels_per_spacing;

  write_print(flags.file, picture, mm_per_pixel);
  const double width = picture.width() * mm_per_pixel, height = picture.height() * mm_per_pixel;
  output.say("wrote a board ({}, {}x{}) to {}, {} pixels", name_of(board.kind), board.columns,
             board.rows, flags.file, text_of(picture.size()));
  output.say("print it at {:.2f} mm x {:.2f} mm, without 'fit to page', then measure the print",
             width, height);

  output.document = described("board", flags.file, "width_px", picture.width(), "height_px",
                              picture.height(), "width_mm", width, "height_mm", height);
}

void add_board_capture_flags(const FlagGroup& command, BoardCaptureFlags& flags) {
  required(command.add_file("folder", flags.folder,
                            "folder with a subfolder per pose: scans x and y (folders, or "
                            "recordings x.slip and y.slip), or the pictures of both"));

  command.add("--exclude", flags.excluded, "names of poses to ignore");
  command.add("--first-axis", flags.first_axis,
              "if both scans lie in one folder: the axis whose pictures come first, x or y");

  command.add("--minimum-modulation", flags.capture.minimum_modulation,
              "minimum modulation for a pixel's phase to be used, grey levels of 255");
  command.add("--neighbourhood", flags.capture.neighbourhood,
              "radius around a corner within which phase is used, in corner spacings");

  add_board_flags(command.app, flags.board);
  add_scan_flags(command.app, flags.scan);
  command.app.remove_option(command.app.get_option("--axis"));
}

/// Finds the board in every pose and reports each. Corrects phases for the response if it is known.
PoseCaptures captured_boards(const BoardCaptureFlags& flags, const CalibrationBoard& board,
                             const std::optional<MeasuredResponse>& response, Output& output) {
  const std::vector<BoardScans> poses =
      board_scans(flags.folder, flags.scan, axis_named(flags.first_axis));

  BoardCaptureSettings settings = flags.capture;
  settings.response = response;
  if (response) {
    output.say("phases are corrected for the scanner file's response, gamma {:.5g}",
               response->gamma);
  }

  Progress progress("poses", poses.size());
  PoseCaptures captures = capture_poses(flags.folder, poses, flags.excluded, board, settings,
                                        [&](const std::string& words) {
                                          if (!words.empty()) output.say("{}", words);
                                          progress.advance();
                                        });

  output.warn(captures.warnings);
  return captures;
}

struct CalibrateVerifyFlags {
  BoardCaptureFlags boards;
  std::string scanner;
  std::optional<std::string> output;
};

nlohmann::json json_of(const ReprojectionRms& rms) {
  return described("camera", rms.camera, "projector", rms.projector, "stereo", rms.stereo);
}

nlohmann::json json_of(const BoardMeasure& measure) {
  return described("epipolar_px", measure.epipolar, "rms", json_of(measure.rms), "flatness_mm",
                   measure.quality.flatness, "scale_error", measure.quality.scale_error);
}

void say_measure(const std::string& what, const BoardMeasure& measure, Output& output) {
  output.say(
      "{}: epipolar distance {:.3f} px, RMS {:.3f} px, flat to {:.4f} mm, scale error {:.3f} %",
      what, measure.epipolar, measure.rms.stereo, measure.quality.flatness,
      100 * measure.quality.scale_error);
}

/// Writes the corrected scanner if requested and if there is something to correct.
void write_corrected(const CalibrateVerifyFlags& flags, const Verification& found, Output& output) {
  if (!flags.output) return;
  if (found.holds) return output.say("{} was not written: nothing to correct", *flags.output);
  if (!found.mended) {
    throw Error(
        fmt::format("{} was not written: {}", *flags.output, text_of(found.findings.back())));
  }

  Scanner corrected = found.corrected;
  if (!corrected.measured.empty()) corrected.measured += "; ";
  corrected.measured += fmt::format("pose corrected by {} boards", found.poses.size());

  write_scanner(*flags.output, corrected);
  output.document["output"] = *flags.output;
  output.say("the corrected scanner file is {}", *flags.output);
}

void verify_calibration(const CalibrateVerifyFlags& flags, Output& output) {
  const CalibrationBoard board = board_from(flags.boards.board);
  const Scanner read = read_scanner(flags.scanner);

  // Scans that do not give the projector's size take it from the scanner file.
  BoardCaptureFlags boards = flags.boards;
  boards.capture.projector = read.projector.size;
  const PoseCaptures captures = captured_boards(boards, board, read.photometry.response, output);
  throw_if(captures.views.empty(), "{}: no pose can be used{}", flags.boards.folder,
           captures.unused.empty() ? "" : " (" + captures.unused[0].why + ")");

  // Verification refits the pose of the projector and compares the boards before and after.
  const Verification found = verify_scanner(
      captures.views, board, completed(read, flags.scanner, captures.camera, captures.projector));

  output.document =
      described("scanner", flags.scanner, "holds", found.holds, "mended", found.mended, "before",
                json_of(found.before), "after", json_of(found.after), "rotation_rad",
                found.rotation, "translation_mm", found.translation);
  output.document["poses"] = as_json(found.poses, [](const VerifiedPose& pose) {
    return described("name", pose.name, "before", json_of(pose.before), "after",
                     json_of(pose.after));
  });

  std::vector<Finding> findings = captures.findings;
  findings.insert(findings.end(), found.findings.begin(), found.findings.end());
  output.document["findings"] = findings;
  output.warn(findings);

  say_measure("uncorrected", found.before, output);
  say_measure("corrected", found.after, output);
  output.say("the correction turns the projector by {:.3f} degrees and moves it by {:.3f} mm",
             found.rotation * 180 / std::numbers::pi, found.translation);
  output.say("{} {}", flags.scanner,
             found.holds    ? "holds"
             : found.mended ? "is wrong; the corrected pose is right"
                            : "is wrong, and a corrected pose does not help");

  write_corrected(flags, found, output);
}

GeometryCalibrationSettings settings_from(const CalibrateGeometryFlags& flags) {
  GeometryCalibrationSettings settings;
  settings.camera_coefficients = lens_model_named(flags.camera_distortion, "--camera-distortion");
  settings.projector_coefficients =
      lens_model_named(flags.projector_distortion, "--projector-distortion");

  throw_if(flags.print != "exact" && flags.print != "estimated",
           "--print {} is unknown; expected estimated or exact", flags.print);
  require_in_range(flags.print_deviation > 0 && flags.print_deviation < 1, "--print-deviation",
                   flags.print_deviation, "more than 0, less than 1");

  // Without a deviation the corners are held at their nominal positions.
  settings.print_deviation =
      flags.print == "exact" ? std::nullopt : std::optional(flags.print_deviation);
  return settings;
}

std::vector<Finding> measured_findings(const CalibrateGeometryFlags& flags,
                                       const CalibrationBoard& board) {
  if (!flags.measured) return {};
  const std::vector<double> lengths = lengths_from(*flags.measured, "--measured");

  throw_if(lengths.size() != 2,
           "--measured {}: expected two lengths, of a row and of a column, e.g. 121.9x80.3",
           *flags.measured);
  return findings_of_ruler(board, {lengths[0], lengths[1]});
}

nlohmann::json json_of(const Lens& lens, const LensDeviation& deviation, const LensChoice& choice,
                       double covered) {
  const Eigen::Matrix3d& K = lens.intrinsic;
  const auto scores = as_json(choice.scores, [](const LensModelScore& score) {
    return described("coefficients", score.coefficients, "left_out_error", score.error);
  });
  return described("focal_px", std::array{K(0, 0), K(1, 1)}, "focal_deviation_px", deviation.focal,
                   "principal_point_px", std::array{K(0, 2), K(1, 2)},
                   "principal_point_deviation_px", deviation.principal_point, "distortion",
                   lens.distortion.coefficients, "distortion_deviation", deviation.coefficients,
                   "distortion_coefficients", choice.coefficients, "distortion_models", scores,
                   "covered_share", covered);
}

/// NaN becomes null.
void add_quality(nlohmann::json& document, const std::optional<BoardQuality>& quality) {
  const BoardQuality known = quality.value_or(BoardQuality{NAN, NAN, NAN});
  describe(document, "flatness_mm", known.flatness, "distance_error_mm", known.distance_error,
           "scale_error", known.scale_error);
}

nlohmann::json json_of_poses(const CalibrationReport& report) {
  const GeometryCalibration& calibration = report.calibration;
  const ScannerComparison* const other = report.comparison;

  // The poses used, with the quality of each when left out of the calibration.
  nlohmann::json poses = nlohmann::json::array();
  for (std::size_t i = 0; i < calibration.poses.size(); ++i) {
    const CalibratedPose& pose = calibration.poses[i];
    nlohmann::json document = described("name", pose.name, "used", true, "rms", json_of(pose.rms),
                                        "corners", pose.corners, "lit_corners", pose.lit);
    add_quality(document, pose.left_out);
    if (other != nullptr) add_quality(document["compared"], other->poses[i]);
    poses.push_back(document);
  }

  // The others, with the reason.
  for (const UnusedPose& pose : report.unused) {
    poses.push_back(described("name", pose.name, "used", false, "reason", pose.why));
  }

  // In the order of their names, used or not.
  std::sort(poses.begin(), poses.end(), [](const auto& a, const auto& b) {
    return before_in_order(a["name"].template get<std::string>(),
                           b["name"].template get<std::string>());
  });

  return poses;
}

nlohmann::json document(const CalibrateGeometryFlags& flags, const CalibrationReport& report) {
  const GeometryCalibration& calibration = report.calibration;
  const Scanner& scanner = calibration.state.scanner;
  nlohmann::json document = described(
      "scanner", flags.scanner, "rms", json_of(calibration.rms), "poses", json_of_poses(report),
      "camera",
      json_of(scanner.camera, calibration.deviation.camera, calibration.camera_lens,
              calibration.covered_camera),
      "projector",
      json_of(scanner.projector, calibration.deviation.projector, calibration.projector_lens,
              calibration.covered_projector),
      "baseline_mm", scanner.translation.norm(), "rotation_deviation_rad",
      calibration.deviation.rotation, "translation_deviation_mm", calibration.deviation.translation,
      "largest_tilt_rad", calibration.largest_tilt, "depths_mm",
      std::array{scanner.calibrated_depths->nearest, scanner.calibrated_depths->farthest});

  add_quality(document, overall(left_out_qualities(calibration)));
  document["findings"] = report.findings;
  document["verdict"] = verdict_of(report.findings).words;

  if (report.comparison != nullptr) {
    document["compared"] = described("scanner", report.comparison->name);
    add_quality(document["compared"], overall(report.comparison->poses));
  }

  if (flags.report) document["report"] = *flags.report;
  return document;
}

}  // namespace

void calibrate_boards(const CalibrateGeometryFlags& flags, Output& output) {
  const CalibrationBoard board = board_from(flags.boards.board);
  const GeometryCalibrationSettings settings = settings_from(flags);
  std::vector<Finding> findings = measured_findings(flags, board);

  // Read the files first: errors in them should not wait for the calibration.
  std::optional<Scanner> other;
  if (flags.compare) other = read_scanner(*flags.compare);
  const auto response = fs::exists(flags.scanner)  // it will be overwritten
                            ? read_photometric_calibration(flags.scanner).response
                            : std::nullopt;

  // 1. Find the board's corners in every pose, in camera pixels and projector coordinates.
  const PoseCaptures captures = captured_boards(flags.boards, board, response, output);
  require_enough_poses(captures, flags.boards.folder);
  if (other) other = completed(*other, *flags.compare, captures.camera, captures.projector);

  // 2. Calibrate both lenses and the pose between them.
  const GeometryCalibration calibration =
      calibrate_geometry(captures.views, board, captures.camera, captures.projector, settings);

  // 3. Compare with the other scanner file, and report all diagnostics together.
  std::optional<ScannerComparison> comparison;
  if (other) {
    comparison = compared_with(*other, fs::path(*flags.compare).filename().string(),
                               calibration.views, board);
  }

  for (const auto* more : {&captures.findings, &calibration.findings}) {
    findings.insert(findings.end(), more->begin(), more->end());
  }

  // 4. Write the scanner file; entries that do not concern the geometry are kept, such as gamma.
  const std::vector<std::string> kept = replace_geometry(flags.scanner, calibration.state.scanner);

  // 5. The report names the file as it is now.
  CalibrationReport report{calibration, captures.unused, board, comparison ? &*comparison : nullptr,
                           findings,    &with_flags};
  if (flags.report) {
    report.facts = facts_of_run(output);
    add_scanner(report.facts, calibration.state.scanner, flags.scanner);
    write_page(fs::path(*flags.report) / "report.html", calibration_report(report));
  }

  output.document = document(flags, report);

  output.say_lines(text_of(report));
  output.warn(findings);
  output.say("{}", verdict_of(findings).words);
  output.say("scanner file: {}", flags.scanner);

  if (flags.report) output.say("report: {}", (fs::path(*flags.report) / "report.html").string());
  if (!kept.empty()) output.say("kept from the existing file: {}", fmt::join(kept, ", "));
}

void add_calibrate_board(const Commands& calibrate) {
  const auto [command, flags] =
      calibrate.add(write_board, "board", "draw a calibration board to print");
  required(command.add_output("-o,--output", flags.file,
                              "the board at true size with a ruler: .pdf or .svg; as a picture: "
                              ".png, .tiff, .bmp or .pgm"));

  command.add("--dpi", flags.dots_per_inch, "pixels for each inch of paper");
  add_board_flags(command.app, flags.board);
  command.examples({"calibrate board --board chessboard --corners 13x9 --spacing 15 -o board.pdf"});
}

void add_calibrate_verify(const Commands& calibrate) {
  const auto [command, flags] =
      calibrate.add(verify_calibration, "verify",
                    "check a scanner file against scans of a board, and correct its pose");
  required(command.add_file("--scanner", flags.scanner, "the scanner file"));
  command.add_output("-o,--output", flags.output,
                     "corrected scanner file, written if the old one is wrong: .yaml or .xml",
                     scanner_output_type);

  add_board_capture_flags(command, flags.boards);
  command.common({"--scanner", "--output", "--board", "--corners", "--spacing", "--strategy",
                  "--steps", "--high", "--low", "--projector"});
  command.examples(
      {"calibrate verify poses --scanner scanner.yaml --corners 13x9 --spacing 10 -o "
       "corrected.yaml"});
}

void add_calibrate(const Commands& program) {
  const Commands calibrate = program.add_group(
      "calibrate", "calibrate a rig: geometry, response, noise, ambient light, colour");

  // In the order of the help.
  for (AddCommand* const add :
       {add_calibrate_board, add_calibrate_geometry, add_calibrate_verify, add_calibrate_gamma,
        add_calibrate_ambient, add_calibrate_noise, add_calibrate_colour, add_calibrate_height}) {
    add(calibrate);
  }
}

void add_calibrate_geometry(const Commands& calibrate_command) {
  const auto [command, flags] = calibrate_command.add(
      calibrate_boards, "geometry",
      "calibrate camera and projector from scans of a board in several poses");
  required(command.add_output("-o,--output", flags.scanner, "the scanner file: .yaml or .xml",
                              scanner_output_type));

  command.add_output("--report", flags.report, "folder for a report with pictures",
                     output_folder_type);
  command.add_file("--compare", flags.compare, "scanner file to compare the result with");

  command.add("--measured", flags.measured,
              "measured on the print with a ruler, first to last corner, mm: row x column");

  add_board_capture_flags(command, flags.boards);
  const FlagGroup model{command.app, "Model"};
  const std::string lenses = fmt::format(
      "lens distortion coefficients: auto, or {} in OpenCV's order", fmt::join(lens_models, ", "));
  model.add("--camera-distortion", flags.camera_distortion, lenses);
  model.add("--projector-distortion", flags.projector_distortion, lenses);
  model.add("--print", flags.print,
            "board corners: exact, or estimated near their nominal positions");
  model.add("--print-deviation", flags.print_deviation,
            "standard deviation of a printed corner's position, in spacings");

  command.common({"--output", "--report", "--board", "--corners", "--spacing", "--strategy",
                  "--steps", "--high", "--low", "--projector"});
  command.examples(
      {"calibrate geometry poses --board chessboard --corners 13x9 --spacing 10 --strategy "
       "dual-frequency --steps 3 --high 16 --low 1 --projector 1824x1140 -o scanner.yaml --report "
       "report"});
}

}  // namespace slipstream::app
