#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "python/bindings/keywords.h"
#include "python/bindings/scans.h"
#include "slipstream/calibrate/board_scans.h"
#include "slipstream/calibrate/geometry_calibration.h"
#include "slipstream/calibrate/pose_captures.h"
#include "slipstream/calibrate/report.h"

namespace slipstream::python {
namespace {
namespace fs = std::filesystem;

/// A calibration, and the poses that took no part.
struct FoundGeometry {
  CalibrationBoard board;
  PoseCaptures captures;
  GeometryCalibration calibration;

  [[nodiscard]] CalibrationReport report() const {
    CalibrationReport report{calibration, calibration.views, captures.unused, board};
    report.findings = findings();
    return report;
  }
  [[nodiscard]] std::vector<Finding> findings() const {
    std::vector<Finding> all = captures.findings;
    all.insert(all.end(), calibration.findings.begin(), calibration.findings.end());
    return all;
  }
};

CalibrationBoard board_from(Keywords& keywords) {
  CalibrationBoard board;
  std::string kind(name_of(board.kind));
  keywords.take("board", kind);
  keywords.take("columns", board.columns);
  keywords.take("rows", board.rows);
  keywords.take("spacing", board.spacing);
  keywords.take("row_spacing", board.row_spacing);
  keywords.take("circle_diameter", board.circle_diameter);
  keywords.take("marker_side", board.marker_side);
  keywords.take("marker_bits", board.marker_bits);
  board.kind = board_kind_named(kind);
  require_valid(board);
  return board;
}

std::shared_ptr<FoundGeometry> calibrated(const fs::path& folder, const py::kwargs& given) {
  Keywords keywords(given);
  auto found = std::make_shared<FoundGeometry>();
  found->board = board_from(keywords);
  std::optional<Sequence> sequence;
  std::string first_axis = "x";
  std::vector<std::string> excluded;
  BoardCaptureSettings capture;
  GeometryCalibrationSettings settings;
  keywords.take("sequence", sequence);
  keywords.take("first_axis", first_axis);
  keywords.take("excluded", excluded);
  keywords.take("minimum_modulation", capture.minimum_modulation);
  keywords.take("neighbourhood", capture.neighbourhood);
  keywords.take("response", capture.response);
  keywords.take("camera_coefficients", settings.camera_coefficients);
  keywords.take("projector_coefficients", settings.projector_coefficients);
  keywords.take("print_deviation", settings.print_deviation);
  keywords.require_none_left();
  ScanChanges changes;
  if (sequence) changes.sequence = changes_to(*sequence);
  {
    const py::gil_scoped_release release;
    const std::vector<BoardScans> poses = board_scans(folder, changes, axis_named(first_axis));
    found->captures = capture_poses(folder.string(), poses, excluded, found->board, capture,
                                    [](const std::string&) {});
    require_enough_poses(found->captures, folder.string());
    found->calibration =
        calibrate_geometry(found->captures.views, found->board, found->captures.camera,
                           found->captures.projector, settings);
  }
  warn_of("", found->captures.warnings);
  return found;
}

std::map<std::string, double> rms_of(const FoundGeometry& of) {
  const ReprojectionRms& rms = of.calibration.rms;
  return {{"camera", rms.camera}, {"projector", rms.projector}, {"stereo", rms.stereo}};
}

std::map<std::string, std::string> unused_of(const FoundGeometry& of) {
  std::map<std::string, std::string> unused;
  for (const UnusedPose& pose : of.captures.unused) unused[pose.name] = pose.why;
  return unused;
}

std::vector<std::string> poses_of(const FoundGeometry& of) {
  std::vector<std::string> names;
  for (const CalibratedPose& pose : of.calibration.poses) names.push_back(pose.name);
  return names;
}

}  // namespace

void bind_calibration(py::module_& module) {
  py::class_<FoundGeometry, std::shared_ptr<FoundGeometry>>(
      module, "GeometryCalibration", "Camera and projector by where both see a board's corners.")
      .def_property_readonly("scanner",
                             [](const FoundGeometry& of) { return of.calibration.state.scanner; })
      .def_property_readonly(
          "rms", &rms_of,
          "Corners as seen against as predicted, pixels: camera, projector, stereo.")
      .def_property_readonly("poses", &poses_of, "Names of those that took part.")
      .def_property_readonly("unused", &unused_of, "Names of the others, and why.")
      .def_property_readonly("findings", &FoundGeometry::findings, "What speaks against it.")
      .def(
          "write_report",
          [](const FoundGeometry& of, const fs::path& folder) {
            write_calibration_report(folder, of.report());
          },
          py::arg("folder"), py::call_guard<py::gil_scoped_release>(),
          "Writes report.md and its pictures.")
      .def("__str__", [](const FoundGeometry& of) { return text_of(of.report()); })
      .def("__repr__", [](const FoundGeometry& of) {
        return py::str("<slipstream.GeometryCalibration of {} poses, RMS {:.3f} px>")
            .format(of.calibration.poses.size(), of.calibration.rms.stereo);
      });
  module.def("calibrate_geometry", &calibrated, py::arg("folder"),
             "Scans of a board in several poses, a folder for each, to a scanner.");
  module.def(
      "draw_board",
      [](int pixels_per_spacing, const py::kwargs& given) {
        Keywords keywords(given);
        const CalibrationBoard board = board_from(keywords);
        keywords.require_none_left();
        return array_from(draw_board(board, pixels_per_spacing));
      },
      py::arg("pixels_per_spacing"), "The board to print, rows x columns.");
}

}  // namespace slipstream::python
