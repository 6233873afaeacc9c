#include "python/bindings/calibration.h"

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/throw_if-inl.h"
#include "calibrate/report.h"
#include "codes/predicted_variance.h"
#include "decode/phase_decoder.h"
#include "io/image_file.h"
#include "python/bindings/arguments.h"
#include "python/bindings/scans.h"
#include "response/ambient_calibration.h"
#include "response/gamma_calibration.h"
#include "response/noise_calibration.h"
#include "response/scan_average.h"
#include "slipstream/gamma.h"
#include "slipstream/scan_files.h"
#include "slipstream/unwrapping.h"

namespace slipstream::python {
namespace {

py::object found_gamma(const py::object& frames, int steps, int first, std::optional<int> bits) {
  const BorrowedFrames given = borrowed(frames, bits);
  const BlindGamma found = unlocked([&] { return find_gamma(given.views, first, steps); });
  return results("gamma"_a = found.gamma, "standard_error"_a = found.standard_error,
                 "pixels"_a = found.pixels,
                 "refusal"_a = found.accepted() ? "" : reason_of(found.refusal));
}

ScanAverage average_of(const py::iterable& scans, bool of_gamma) {
  ScanAverage average;
  for (const py::handle of : scans) {
    const auto [scan, name] = checked_scan(of, of_gamma);
    if (!of_gamma) require_ambient_measurable(scan, name);
    average.add(scan, name);
  }
  return average;
}

py::object calibrated_gamma(const py::iterable& scans, double minimum_modulation) {
  const ScanAverage average = average_of(scans, true);
  const auto found = unlocked([&] { return calibrate_gamma(average, minimum_modulation); });

  const MeasuredResponse response = found_response(found);
  return results("response"_a = response, "gamma"_a = response.gamma,
                 "standard_error"_a = response.standard_error, "steps"_a = found.steps,
                 "misfit"_a = found.misfit);
}

py::object calibrated_noise(const py::iterable& scans) {
  std::vector<NoiseScan> read;
  for (const py::handle of : scans) read.emplace_back(checked_scan(of, false).first);

  const std::vector<NoiseMeasurement> all = unlocked([&] { return calibrate_noise(read); });

  // Without a line over the grey levels: the most trusted measurement, and no gain.
  const NoiseLine line = noise_line(read).value_or(NoiseLine{.at_half = all.front().variance});

  py::list measurements;
  for (const NoiseMeasurement& of : all) {
    measurements.append(results("equation"_a = of.equation, "method"_a = of.method,
                                "variance"_a = of.variance, "standard_error"_a = of.standard_error,
                                "reason"_a = of.reason));
  }

  return results("variance"_a = line.at_half, "gain"_a = line.gain,
                 "measurements"_a = measurements);
}

py::object calibrated_ambient(const py::iterable& scans, double least_alpha,
                              const std::optional<MeasuredResponse>& measured) {
  const ScanAverage average = average_of(scans, false);

  std::optional<Response> response;
  if (measured) response = measured->response;

  const AmbientEstimate found =
      unlocked([&] { return calibrate_ambient(average, least_alpha, response).estimate; });

  return results("mode"_a = found.mode, "median"_a = found.median, "mean"_a = found.mean,
                 "variance"_a = found.variance, "pixels"_a = found.pixels);
}

py::tuple phases_of(const py::object& frames, int steps, int first, std::optional<int> bits) {
  const BorrowedFrames given = borrowed(frames, bits);
  throw_if(first < 0 || steps < 3 || first + steps > given.views.count(),
           "frames {} to {} of {}; expected 3 steps or more", first, first + steps - 1,
           given.views.count());

  PhaseMaps maps = unlocked(
      [&] { return PhaseDecoder(PhaseMethod::equation, {steps})(given.views, first, steps); });

  return py::make_tuple(array_from(std::move(maps.mean)), array_from(std::move(maps.modulation)),
                        array_from(std::move(maps.wrapped_phase)));
}

double unwrapped(double wrapped_phase, double frequency, double coarse) {
  if (!std::isfinite(wrapped_phase + coarse)) return std::numeric_limits<double>::quiet_NaN();
  return unwrapped_coordinate(wrapped_phase, fringe_order(wrapped_phase, frequency, coarse),
                              frequency);
}

CalibrationBoard board_from(Keywords& keywords) {
  CalibrationBoard board;
  std::string kind(name_of(board.kind));

  keywords.take("board", kind, "columns", board.columns, "rows", board.rows, "spacing",
                board.spacing, "row_spacing", board.row_spacing, "circle_diameter",
                board.circle_diameter, "marker_side", board.marker_side, "marker_bits",
                board.marker_bits);

  board.kind = board_kind_named(kind);
  require_valid(board);
  return board;
}

/// A calibration with what its report refers to.
struct HeldCalibration {
  GeometryCalibration found{};
  std::vector<UnusedPose> unused{};
  CalibrationBoard board{};
  std::vector<Finding> findings{};

  [[nodiscard]] CalibrationReport report() const {
    return {found, unused, board, nullptr, findings};
  }

  void write(const fs::path& path) const { write_page(path, calibration_report(report())); }
};

HeldCalibration calibrated(const fs::path& folder, const std::optional<fs::path>& report_folder,
                           const py::kwargs& given) {
  // 1. The keywords.
  Keywords keywords(given);
  const CalibrationBoard board = board_from(keywords);

  ScanChanges changes;
  std::optional<Sequence> sequence;
  std::string first_axis = "x";
  std::vector<std::string> excluded;
  BoardCaptureSettings capture;
  GeometryCalibrationSettings model;

  keywords.take("sequence", sequence, "first_axis", first_axis, "excluded", excluded,
                "minimum_modulation", capture.minimum_modulation, "neighbourhood",
                capture.neighbourhood, "response", capture.response, "camera_coefficients",
                model.camera_coefficients, "projector_coefficients", model.projector_coefficients,
                "print_deviation", model.print_deviation);
  keywords.require_none_left();

  if (sequence) changes.sequence = changes_to(*sequence);

  // 2. Reads the poses and calibrates, without the interpreter's lock.
  PoseCaptures captures;
  const auto found = unlocked([&] {
    captures = capture_poses(folder.string(), board_scans(folder, changes, axis_named(first_axis)),
                             excluded, board, capture, [](const std::string&) {});
    require_enough_poses(captures, folder.string());
    return calibrate_geometry(captures.views, board, captures.camera, captures.projector, model);
  });

  // 3. The report, with the findings about the frames before those about the geometry.
  warn_of("", captures.warnings);
  HeldCalibration held{found, captures.unused, board, captures.findings};
  held.findings.insert(held.findings.end(), found.findings.begin(), found.findings.end());

  if (report_folder) held.write(fs::path(*report_folder) / "report.html");
  return held;
}

std::vector<std::string> names_of(const std::vector<CalibratedPose>& poses) {
  std::vector<std::string> names;
  for (const CalibratedPose& pose : poses) names.push_back(pose.name);
  return names;
}

void bind_report(py::module_& module) {
  py::class_<HeldCalibration> report(module, "CalibrationReport");

  add(
      report, "scanner", [](HeldCalibration& of) -> Scanner& { return of.found.state.scanner; },
      "poses", [](const HeldCalibration& of) { return names_of(of.found.poses); }, "unused",
      [](const HeldCalibration& of) { return dict_of(of.unused); }, "rms",
      [](const HeldCalibration& of) {
        const auto [camera, projector, stereo] = of.found.rms;
        return py::dict("camera"_a = camera, "projector"_a = projector, "stereo"_a = stereo);
      },
      "findings", &HeldCalibration::findings, "text",
      [](const HeldCalibration& of) { return text_of(of.report()); });

  report.def("write", &HeldCalibration::write, "path"_a, Unlocked());
}

}  // namespace

void bind_calibration(py::module_& module) {
  bind_report(module);

  // The photometry, from scans.
  module.def("find_gamma", &found_gamma, "frames"_a, "steps"_a, "first"_a = 0, py::kw_only(),
             "bits"_a = py::none());
  module.def("calibrate_gamma", &calibrated_gamma, "scans"_a, py::kw_only(),
             "minimum_modulation"_a = 0.);
  module.def("calibrate_noise", &calibrated_noise, "scans"_a);
  module.def("calibrate_ambient", &calibrated_ambient, "scans"_a, py::kw_only(),
             "least_alpha"_a = 0.5, "response"_a = py::none());

  // Phases, coordinates and their variances, on arrays.
  module.def("phases", &phases_of, "frames"_a, "steps"_a, "first"_a = 0, py::kw_only(),
             "bits"_a = py::none());
  module.def("unwrap", py::vectorize(&unwrapped), "wrapped_phase"_a, "frequency"_a,
             "coarse_coordinate"_a);

  module.def("phase_variance",
             py::vectorize(py::overload_cast<int, double, double, double>(&phase_variance)),
             "steps"_a, "alpha"_a, "alpha_p"_a, "noise_variance"_a);
  module.def("coordinate_variance",
             py::vectorize(py::overload_cast<double, double>(&coordinate_variance)),
             "phase_variance"_a, "frequency"_a);

  // The geometry, from a folder of poses.
  module.def("calibrate_geometry", &calibrated, "folder"_a, "report"_a = py::none());
}

}  // namespace slipstream::python
