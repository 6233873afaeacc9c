#include "app/calibration_result.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/ranges.h>

#include "app/flag_names.h"
#include "app/report_facts.h"
#include "calibrate/report.h"
#include "io/image_file.h"
#include "io/scan_pictures.h"
#include "slipstream/scanner_file.h"

namespace slipstream::app {
namespace {

nlohmann::json json_of(const Lens& lens, const LensDeviation& deviation, const LensChoice& choice,
                       const ResidualChoice& residual, double covered) {
  const Eigen::Matrix3d& K = lens.intrinsic;
  const auto scores = as_json(choice.scores, [](const LensModelScore& score) {
    return described("coefficients", score.coefficients, "left_out_error", score.error);
  });
  const auto residuals = as_json(residual.scores, [](const ResidualScore& score) {
    return described("degree", score.degree, "left_out_error", score.error, "left_out_px",
                     score.rms);
  });
  return described("focal_px", std::array{K(0, 0), K(1, 1)}, "focal_deviation_px", deviation.focal,
                   "principal_point_px", std::array{K(0, 2), K(1, 2)},
                   "principal_point_deviation_px", deviation.principal_point, "distortion",
                   lens.distortion.coefficients, "distortion_deviation", deviation.coefficients,
                   "distortion_coefficients", choice.coefficients, "distortion_models", scores,
                   "residual_degree", residual.degree, "residual_maps", residuals, "covered_share",
                   covered);
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
    nlohmann::json document =
        described("name", pose.name, "used", true, "rms", json_of_rms(pose.rms), "corners",
                  pose.corners, "lit_corners", pose.lit);
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

nlohmann::json document(const CalibrationResultFlags& flags, const CalibrationReport& report) {
  const GeometryCalibration& calibration = report.calibration;
  const Scanner& scanner = calibration.state.scanner;
  nlohmann::json document = described(
      "scanner", flags.scanner, "rms", json_of_rms(calibration.rms), "poses", json_of_poses(report),
      "camera",
      json_of(scanner.camera, calibration.deviation.camera, calibration.camera_lens,
              calibration.camera_residual, calibration.covered_camera),
      "projector",
      json_of(scanner.projector, calibration.deviation.projector, calibration.projector_lens,
              calibration.projector_residual, calibration.covered_projector),
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

void add_result_flags(const FlagGroup& command, CalibrationResultFlags& flags) {
  required(command.add_output("-o,--output", flags.scanner, "the scanner file: .yaml or .xml",
                              scanner_output_type));
  command.add_output("--report", flags.report, "folder for a report with pictures",
                     output_folder_type);
  command.add_file("--compare", flags.compare, "scanner file to compare the result with");
}

void add_model_flags(const FlagGroup& model, CalibrationResultFlags& flags) {
  const std::string lenses = fmt::format(
      "lens distortion coefficients: auto, or {} in OpenCV's order", fmt::join(lens_models, ", "));
  model.add("--camera-distortion", flags.camera_distortion, lenses);
  model.add("--projector-distortion", flags.projector_distortion, lenses);
  model.add("--print", flags.print,
            "board corners: exact, or estimated near their nominal positions");
  model.add("--print-deviation", flags.print_deviation,
            "standard deviation of a printed corner's position, in spacings");
  model.add("--residual", flags.residual,
            "add maps of the lens models' remainders, as far as held-out poses support them");
}

GeometryCalibrationSettings settings_from(const CalibrationResultFlags& flags) {
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
  settings.residual = flags.residual;
  return settings;
}

std::optional<Scanner> compared_scanner(const CalibrationResultFlags& flags) {
  if (!flags.compare) return std::nullopt;
  return read_scanner(*flags.compare);
}

nlohmann::json json_of_rms(const ReprojectionRms& rms) {
  return described("camera", rms.camera, "projector", rms.projector, "stereo", rms.stereo);
}

void write_calibration(const CalibrationResultFlags& flags, const CalibrationResult& result,
                       std::optional<Scanner> other, Output& output) {
  const GeometryCalibration& calibration = result.calibration;
  const Scanner& scanner = calibration.state.scanner;

  // 1. Compare with the other scanner file.
  std::optional<ScannerComparison> comparison;
  if (other) {
    other = completed(*other, *flags.compare, scanner.camera.size, scanner.projector.size);
    comparison = compared_with(*other, fs::path(*flags.compare).filename().string(),
                               calibration.views, result.places);
  }

  // 2. Write the scanner file; entries that do not concern the geometry are kept, such as gamma.
  const std::vector<std::string> kept = replace_geometry(flags.scanner, scanner);

  // 3. The report, with all diagnostics together. It names the file as it is now.
  std::vector<Finding> findings = result.findings;
  findings.insert(findings.end(), calibration.findings.begin(), calibration.findings.end());
  CalibrationReport report{calibration,  result.unused,
                           result.board, comparison ? &*comparison : nullptr,
                           findings,     &with_flags};
  if (flags.report) {
    report.facts = facts_of_run(output);
    add_scanner(report.facts, scanner, flags.scanner);
    report.facts.insert(report.facts.end(), result.facts.begin(), result.facts.end());
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

}  // namespace slipstream::app
