#include "calibrate/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/ranges.h>

#include "base/numbers.h"
#include "base/printable.h"
#include "base/statistics.h"
#include "calibrate/board_view.h"
#include "calibrate/reprojection.h"
#include "calibrate/residual_pictures.h"

namespace slipstream {
namespace {

std::vector<std::string> cells(const std::optional<BoardQuality>& quality) {
  if (!quality) return {"-", "-", "-"};
  return {fmt::format("{:.4f}", quality->flatness), fmt::format("{:.4f}", quality->distance_error),
          fmt::format("{:.3f}", 100 * quality->scale_error)};
}

void write_findings(Page& page, const std::vector<Finding>& findings) {
  page.verdict(verdict_of(findings));
  if (findings.empty()) return;

  page.heading("Diagnostics");
  page.table({"symptom", "evidence", "likely cause", "remedy"});
  for (const Finding& finding : findings) {
    std::vector<std::string> numbers;
    for (const Evidence& evidence : finding.evidence) {
      numbers.push_back(fmt::format("{}: {:.3g}", name_with_unit(evidence), evidence.value));
    }

    page.row({symptom_of(finding), fmt::format("{}", fmt::join(numbers, "; ")), causes_of(finding),
              remedies_of(finding)});
  }
}

void write_poses(Page& page, const CalibrationReport& report) {
  page.heading("Poses");
  page.paragraph("RMS distances between observed and predicted corners, in pixels of the device.");
  page.table({"pose", "corners", "with projector coordinate", "camera", "projector", "stereo"});

  const auto row = [&](const std::string& name, const std::string& corners, const std::string& lit,
                       const ReprojectionRms& rms) {
    page.row({name, corners, lit, fmt::format("{:.3f}", rms.camera),
              fmt::format("{:.3f}", rms.projector), fmt::format("{:.3f}", rms.stereo)});
  };

  for (const CalibratedPose& pose : report.calibration.poses) {
    row(pose.name, std::to_string(pose.corners), std::to_string(pose.lit), pose.rms);
  }
  row("all", "", "", report.calibration.rms);

  for (const UnusedPose& pose : report.unused) {
    page.paragraph("{} was not used: {}.", pose.name, pose.why);
  }
}

void write_left_out(Page& page, const CalibrationReport& report) {
  const GeometryCalibration& calibration = report.calibration;
  const ScannerComparison* other = report.comparison;
  page.heading("Measurement accuracy");
  page.paragraph(
      "Each pose's board, measured with a calibration of all other poses: the RMS distance of its "
      "corners from their best plane, the RMS error of the distances between all pairs of corners, "
      "and the mean relative error of these distances. The last two rely on the configured "
      "spacing: only a ruler (`measured`) reveals a print of another scale.{}",
      other != nullptr ? fmt::format(" For comparison, the same corners measured with {}, which "
                                     "may have been made from these poses.",
                                     other->name)
                       : "");

  std::vector<std::string> columns{"pose"};
  const auto add_columns = [&](const std::string& of) {
    for (const char* column : {"flatness, mm", "distances, mm", "scale error, %"}) {
      columns.push_back(of + column);
    }
  };

  add_columns("");
  if (other != nullptr) add_columns(other->name + ": ");
  page.table(columns);

  const auto row = [&](const std::string& name, const std::optional<BoardQuality>& ours,
                       const std::optional<BoardQuality>& theirs) {
    std::vector<std::string> all{name};
    std::ranges::copy(cells(ours), std::back_inserter(all));
    if (other != nullptr) std::ranges::copy(cells(theirs), std::back_inserter(all));
    page.row(all);
  };

  for (std::size_t i = 0; i < calibration.poses.size(); ++i) {
    const CalibratedPose& pose = calibration.poses[i];
    row(pose.name, pose.left_out, other != nullptr ? other->poses[i] : std::nullopt);
  }

  row("root mean square", overall(left_out_qualities(calibration)),
      other != nullptr ? std::optional(overall(other->poses)) : std::nullopt);
}

void write_parameters(Page& page, const GeometryCalibration& calibration) {
  static constexpr std::array names{"k1", "k2", "p1", "p2", "k3", "k4",
                                    "k5", "k6", "s1", "s2", "s3", "s4"};
  const Scanner& scanner = calibration.state.scanner;
  const BundleDeviation& deviation = calibration.deviation;
  const Eigen::AngleAxisd turn(scanner.rotation);
  const Eigen::Vector3d angles = turn.angle() * turn.axis() / degree;

  page.heading("Parameters");
  page.paragraph(
      "The standard deviation is the larger of two: the effect of independent corner noise, and "
      "the scatter of calibrations that each omit one pose.");
  page.table({"parameter", "value", "standard deviation", "unit"});

  const auto row = [&](std::string name, double value, double its_deviation, const char* unit) {
    page.row({std::move(name), fmt::format("{:.6g}", value),
              its_deviation > 0 ? fmt::format("{:.2g}", its_deviation) : "held", unit});
  };

  const auto add_lens = [&](const std::string& device, const Lens& lens, const LensDeviation& off,
                            int coefficients) {
    const Eigen::Matrix3d& K = lens.intrinsic;
    row(device + " fx", K(0, 0), off.focal.x(), "px");
    row(device + " fy", K(1, 1), off.focal.y(), "px");
    row(device + " cx", K(0, 2), off.principal_point.x(), "px");
    row(device + " cy", K(1, 2), off.principal_point.y(), "px");

    for (int i = 0; i < coefficients; ++i) {
      row(fmt::format("{} {}", device, names[i]), lens.distortion.coefficients[i],
          off.coefficients[i], "");
    }
  };

  add_lens("camera", scanner.camera, deviation.camera, calibration.camera_lens.coefficients);
  add_lens("projector", scanner.projector, deviation.projector,
           calibration.projector_lens.coefficients);

  for (int i = 0; i < 3; ++i) {
    row(fmt::format("rotation about {}", "xyz"[i]), angles[i], deviation.rotation[i] / degree,
        "degrees");
  }
  for (int i = 0; i < 3; ++i) {
    row(fmt::format("translation {}", "xyz"[i]), scanner.translation[i], deviation.translation[i],
        "mm");
  }

  page.paragraph("Baseline: {:.3f} mm.", scanner.translation.norm());
}

void write_lens_models(Page& page, const GeometryCalibration& calibration) {
  const LensChoice &camera = calibration.camera_lens, &projector = calibration.projector_lens;
  page.heading("Lens models");
  page.paragraph("Camera: {}. Projector: {}.", name_of_lens_model(camera.coefficients),
                 name_of_lens_model(projector.coefficients));
  if (camera.scores.empty() && projector.scores.empty()) return;

  page.paragraph(
      "RMS error of both devices on held-out poses, in standard deviations, over all poses in "
      "turn. The simplest model that is not clearly worse than the best is chosen.");
  page.table({"model", "camera", "projector"});

  const auto score = [](const LensChoice& choice, int model) {
    const auto found = std::ranges::find(choice.scores, model, &LensModelScore::coefficients);
    return found != choice.scores.end() ? fmt::format("{:.4f}", found->error) : std::string("-");
  };

  for (const int model : lens_models) {
    page.row(
        {std::string(name_of_lens_model(model)), score(camera, model), score(projector, model)});
  }
}

void write_residual(Page& page, const GeometryCalibration& calibration) {
  const Scanner& scanner = calibration.state.scanner;
  for (const auto& [device, name, lens, choice] :
       {std::tuple(Device::camera, "camera", scanner.camera, calibration.camera_residual),
        std::tuple(Device::projector, "projector", scanner.projector,
                   calibration.projector_residual)}) {
    if (choice.scores.empty()) continue;

    page.heading(fmt::format("Residual map of the {}", name));
    page.paragraph(
        "The remainder of the lens model, as polynomials of a degree, fitted without some of the "
        "poses and tried on these: RMS error of their corners in the {0}'s picture, and of both "
        "devices in standard deviations. Chosen: {1}.",
        name, choice.degree > 0 ? fmt::format("degree {}", choice.degree) : "none");

    page.table({"degree", "held-out RMS, px", "held-out error"});
    for (const ResidualScore& score : choice.scores) {
      page.row({score.degree > 0 ? std::to_string(score.degree) : "none",
                fmt::format("{:.4f}", score.rms), fmt::format("{:.4f}", score.error)});
    }

    if (choice.degree == 0) continue;
    page.picture(fmt::format("residual map of the {}", name), fmt::format("map_{}.png", name),
                 drawn_residual(calibration.views, lens, device));
  }
}

/// "camera of degree 6, held-out corners off by 0.031 px instead of 0.080 px".
std::string words_of(const char* device, const ResidualChoice& choice) {
  if (choice.degree == 0) return fmt::format("{} none, as held-out poses support none", device);

  const auto chosen = std::ranges::find(choice.scores, choice.degree, &ResidualScore::degree);
  return fmt::format("{} of degree {}, held-out corners off by {:.4f} px instead of {:.4f} px",
                     device, choice.degree, chosen->rms, choice.scores.front().rms);
}

void write_field(Page& page, const GeometryCalibration& calibration) {
  page.heading("Field of view and residuals");
  page.paragraph(
      "The boards covered {:.0f} % of the camera's picture and {:.0f} % of the projector's; the "
      "largest angle between two boards was {:.0f} degrees.",
      100 * calibration.covered_camera, 100 * calibration.covered_projector,
      calibration.largest_tilt / degree);

  page.paragraph(
      "Enlarged arrows show observed minus predicted corners; they should look random. A pattern "
      "common to all poses indicates too simple a lens model, one pose with long arrows a board "
      "that moved.");

  const Scanner& scanner = calibration.state.scanner;
  const BoardViews& views = calibration.views;
  for (const auto& [device, name, size] :
       {std::tuple(Device::camera, "camera", scanner.camera.size),
        std::tuple(Device::projector, "projector", scanner.projector.size)}) {
    Residuals of_views;
    for (std::size_t v = 0; v < views.size(); ++v) {
      of_views.push_back(residuals(views[v], calibration.state, v, device));
    }

    page.picture(fmt::format("residuals of the {} over its picture", name),
                 fmt::format("residuals_{}.png", name),
                 residual_map(views, views, of_views, device, size));
    page.picture(fmt::format("residuals of the {}, x against y", name),
                 fmt::format("scatter_{}.png", name), residual_scatter(views, of_views));
  }
}

}  // namespace

Verdict verdict_of(const std::vector<Finding>& findings) {
  if (findings.empty()) return {"good", "Good: no problems found."};
  const Finding& first = findings.front();
  if (any_wrong(findings))
    return {"bad", "Do again: " + symptom_of(first) + ". " + remedies_of(first)};
  return {"usable", "Usable, with a warning: " + symptom_of(first)};
}

ScannerComparison compared_with(const Scanner& scanner, const std::string& name,
                                const BoardViews& views, const BoardPlaces& places) {
  ScannerComparison comparison{name, {}};
  for (const BoardView& view : views) {
    comparison.poses.push_back(board_quality(view, scanner, places));
  }
  return comparison;
}

std::string text_of(const CalibrationBoard& board) {
  return fmt::format("{} of {}x{}, {:g} mm apart", name_of(board.kind), board.columns, board.rows,
                     board.spacing);
}

std::vector<std::optional<BoardQuality>> left_out_qualities(
    const GeometryCalibration& calibration) {
  std::vector<std::optional<BoardQuality>> qualities;
  for (const CalibratedPose& pose : calibration.poses) qualities.push_back(pose.left_out);
  return qualities;
}

BoardQuality overall(const std::vector<std::optional<BoardQuality>>& poses) {
  Squares flatness, scale, distances;
  for (const std::optional<BoardQuality>& pose : poses) {
    if (!pose) continue;
    flatness.add(pose->flatness * pose->flatness);
    scale.add(pose->scale_error * pose->scale_error);
    distances.add(pose->distance_error * pose->distance_error);
  }

  if (flatness.count == 0) return {nan, nan, nan};
  return {flatness.rms(), scale.rms(), distances.rms()};
}

std::string text_of(const CalibrationReport& report) {
  const GeometryCalibration& calibration = report.calibration;
  const auto& [camera, projector, stereo] = calibration.rms;
  const BoardQuality left_out = overall(left_out_qualities(calibration));

  const auto described = [](const BoardQuality& quality) {
    return fmt::format("flat to {:.4f} mm, distances off by {:.4f} mm, scale error {:.3f} %",
                       quality.flatness, quality.distance_error, 100 * quality.scale_error);
  };

  std::string text = fmt::format(
      "RMS: camera {:.3f} px, projector {:.3f} px, stereo {:.3f} px\n"
      "held-out poses, measured with a calibration of the others: {}\n",
      camera, projector, stereo, described(left_out));

  if (report.comparison != nullptr) {
    const BoardQuality compared = overall(report.comparison->poses);
    text += fmt::format("measured with {}: {}\n", printable(report.comparison->name),
                        described(compared));
  }

  text += fmt::format("lens models: camera {}, projector {}",
                      name_of_lens_model(calibration.camera_lens.coefficients),
                      name_of_lens_model(calibration.projector_lens.coefficients));

  if (!calibration.camera_residual.scores.empty()) {
    text += fmt::format("\nresidual maps: {}; {}", words_of("camera", calibration.camera_residual),
                        words_of("projector", calibration.projector_residual));
  }
  return text;
}

Page calibration_report(const CalibrationReport& report) {
  const GeometryCalibration& calibration = report.calibration;
  Page page("Calibration of a camera and a projector", report.wording);
  page.paragraph("{} poses of a {}. RMS: camera {:.3f} px, projector {:.3f} px, stereo {:.3f} px.",
                 calibration.poses.size(), report.board, calibration.rms.camera,
                 calibration.rms.projector, calibration.rms.stereo);

  page.facts(report.facts);
  write_findings(page, report.findings);
  write_poses(page, report);
  write_left_out(page, report);
  write_parameters(page, calibration);
  write_lens_models(page, calibration);
  write_residual(page, calibration);
  write_field(page, calibration);
  page.signature();
  return page;
}

}  // namespace slipstream
