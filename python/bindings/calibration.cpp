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
#include "python/bindings/bindings.h"
#include "python/bindings/given.h"
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

ScanAverage average_of(const py::object& scans, bool of_gamma) {
  ScanAverage average;
  for (const py::object& item : each_scan(scans)) {
    const auto [scan, name] = checked_scan(item, of_gamma);
    if (!of_gamma) require_ambient_measurable(scan, name);
    average.add(scan, name);
  }
  return average;
}

py::object calibrated_gamma(const py::object& scans, double minimum_modulation) {
  const ScanAverage average = average_of(scans, true);
  const auto found = unlocked([&] { return calibrate_gamma(average, minimum_modulation); });

  const MeasuredResponse response = found_response(found);
  return results("response"_a = response, "gamma"_a = response.gamma,
                 "standard_error"_a = response.standard_error, "steps"_a = found.steps,
                 "misfit"_a = found.misfit);
}

py::object calibrated_noise(const py::object& scans) {
  std::vector<NoiseScan> read;
  for (const py::object& item : each_scan(scans))
    read.emplace_back(checked_scan(item, false).first);

  const std::vector<NoiseMeasurement> all = unlocked([&] { return calibrate_noise(read); });

  // Without a line over the grey levels: the most trusted measurement, and no gain.
  const NoiseLine line = noise_line(read).value_or(NoiseLine{.at_half = all.front().variance});

  py::list measurements;
  for (const NoiseMeasurement& item : all) {
    measurements.append(results(
        "equation"_a = item.equation, "method"_a = item.method, "variance"_a = item.variance,
        "standard_error"_a = item.standard_error, "reason"_a = item.reason));
  }

  return results("variance"_a = line.at_half, "gain"_a = line.gain,
                 "measurements"_a = measurements);
}

py::object calibrated_ambient(const py::object& scans, double least_alpha,
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

/// A calibration, with the data of its report.
struct HeldCalibration {
  GeometryCalibration found{};
  std::vector<UnusedPose> unused{};
  CalibrationBoard board{};
  std::vector<Finding> findings{};

  [[nodiscard]] CalibrationReport report() const {
    return {found, unused, text_of(board), nullptr, findings};
  }

  void write(const fs::path& path) const { write_page(path, calibration_report(report())); }
};

HeldCalibration calibrated(const fs::path& folder, const std::optional<fs::path>& report_folder,
                           const py::kwargs& kwargs) {
  // 1. The keywords.
  Keywords keywords(kwargs);
  const CalibrationBoard board = board_from(keywords);

  ScanChanges changes;
  std::optional<Given<Sequence>> sequence;
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

  if (sequence) changes.sequence = changes_to(sequence->value);

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

/// Reprojection errors, pixels.
py::dict rms_of(const HeldCalibration& self) {
  const auto [camera, projector, stereo] = self.found.rms;
  return py::dict("camera"_a = camera, "projector"_a = projector, "stereo"_a = stereo);
}

py::dict unused_of(const HeldCalibration& self) {
  py::dict reasons;
  for (const auto& [name, why] : self.unused) reasons[py::str(name)] = with_keywords(why);
  return reasons;
}

void bind_report(py::module_& module) {
  py::class_<HeldCalibration> report(module, "CalibrationReport", R"(
      A calibrated scanner and how well it fits the boards.

      Example:
          >>> report = slipstream.calibrate_geometry("poses", columns=9, rows=6)  # doctest: +SKIP
  )");

  report.def_property_readonly(
      "scanner", [](HeldCalibration& self) -> Scanner& { return self.found.state.scanner; },
      "Scanner: calibrated.");
  report.def_property_readonly(
      "poses", [](const HeldCalibration& self) { return names_of(self.found.poses); },
      "list[str]: names of the poses used.");
  report.def_property_readonly("unused", &unused_of,
                               "dict[str, str]: reason for each pose not used.");
  report.def_property_readonly("rms", &rms_of,
                               "dict[str, float]: reprojection error of camera, projector and "
                               "stereo, pixels.");
  report.def_readonly("findings", &HeldCalibration::findings, "list[Finding]: diagnostics.");
  report.def_property_readonly(
      "text", [](const HeldCalibration& self) { return with_keywords(text_of(self.report())); },
      "str: summary of a few lines.");

  report.def("write", &HeldCalibration::write, "path"_a, Unlocked(), R"(
      Writes the report as one page with its pictures inside.

      Args:
          path (str | PathLike): .html.

      Raises:
          WorldError: if the file cannot be written.

      Example:
          >>> report.write("report.html")  # doctest: +SKIP
  )");
}

void bind_gamma_calibrations(py::module_& module) {
  module.def("find_gamma", &found_gamma, "frames"_a, "steps"_a, "first"_a = 0, py::kw_only(),
             "bits"_a = py::none(), R"(
      Gamma estimated from the frames of one sinusoid alone.

      Args:
          frames (Frames | NDArray | typing.Sequence[NDArray]): see `Frames`.
          steps (int): phase steps of the sinusoid, 3 or more.
          first (int): index of the sinusoid's first frame.
          bits (int | None): bits per pixel; of uint16 frames by default 16.

      Returns:
          SimpleNamespace: estimate.
              gamma (float): estimate.
              standard_error (float): of gamma.
              pixels (int): used.
              refusal (str): why unreliable, else empty.

      Raises:
          Error: if the number, size or type of the frames is wrong.

      Example:
          >>> slipstream.find_gamma(scan.frames, 3).pixels >= 0
          True
  )");

  module.def("calibrate_gamma", &calibrated_gamma, "scans"_a, py::kw_only(),
             "minimum_modulation"_a = 0., R"(
      A scanner's response, best from scans with 8 steps or more.

      Args:
          scans (Iterable[Scan | str | PathLike] | Scan | str | PathLike): scans of one static
              scene, or their paths.
          minimum_modulation (float): least modulation of a pixel, grey levels of 255.

      Returns:
          SimpleNamespace: response.
              response (Response): for `scanner.response`.
              gamma (float): exponent.
              steps (int): used.
              standard_error (float): of gamma.
              misfit (float): phase error left by a power law, rad.

      Raises:
          Error: if a scan is refused.

      Example:
          >>> round(slipstream.calibrate_gamma(flats).gamma)
          1
  )");
}

void bind_light_calibrations(py::module_& module) {
  module.def("calibrate_noise", &calibrated_noise, "scans"_a, R"(
      A scanner's noise variance and gain.

      Args:
          scans (Iterable[Scan | str | PathLike] | Scan | str | PathLike): scans of one static
              scene, or their paths.

      Returns:
          SimpleNamespace: noise.
              variance (float): for `scanner.noise_variance`.
              gain (float): for `scanner.noise_gain`.
              measurements (list[SimpleNamespace]): most reliable first.
                  equation (str): number.
                  method (str): in words.
                  variance (float): squared grey levels of 255.
                  standard_error (float): of the variance.
                  reason (str): why unreliable, else empty.

      Raises:
          Error: if a scan is refused.

      Example:
          >>> slipstream.calibrate_noise(flats).variance > 0
          True
  )");

  module.def("calibrate_ambient", &calibrated_ambient, "scans"_a, py::kw_only(),
             "least_alpha"_a = 0.5, "response"_a = py::none(), R"(
      Ambient light, from scans of a bright surface.

      Args:
          scans (Iterable[Scan | str | PathLike] | Scan | str | PathLike): scans of one static
              scene, or their paths.
          least_alpha (float): least reflectivity of a pixel.
          response (Response | None): from pattern values to light; None if unknown.

      Returns:
          SimpleNamespace: ambient light, grey levels of 255.
              mode (float): most frequent, for `scanner.ambient`.
              pixels (int): used.
              median (float): grey levels of 255.
              mean (float): grey levels of 255.
              variance (float): squared grey levels of 255.

      Raises:
          Error: if a scan is refused.

      Example:
          >>> slipstream.calibrate_ambient(flats, least_alpha=0.3).pixels > 0
          True
  )");
}

void bind_phases(py::module_& module) {
  module.def("phases", &phases_of, "frames"_a, "steps"_a, "first"_a = 0, py::kw_only(),
             "bits"_a = py::none(), R"(
      Mean, modulation and wrapped phase of N-step frames.

      Args:
          frames (Frames | NDArray | typing.Sequence[NDArray]): see `Frames`.
          steps (int): phase steps of the sinusoid, 3 or more.
          first (int): index of the sinusoid's first frame.
          bits (int | None): bits per pixel; of uint16 frames by default 16.

      Returns:
          tuple[NDArray[float64], NDArray[float64], NDArray[float64]]: rows x columns each; the
              phase in rad, 0 to 2 pi.

      Raises:
          Error: if the number, size or type of the frames is wrong.

      Example:
          >>> mean, modulation, phase = slipstream.phases(scan.frames, 3)
  )");

  module.def("unwrap", py::vectorize(&unwrapped), "wrapped_phase"_a, "frequency"_a,
             "coarse_coordinate"_a, R"(
      Projector coordinate by the fringe order nearest to a coarse one, Eq. (1.17).

      Args:
          wrapped_phase (ArrayLike): rad, any shape.
          frequency (ArrayLike): periods across the field.
          coarse_coordinate (ArrayLike): to within half a period.

      Returns:
          Any: 0 to 1.

      Example:
          >>> round(float(slipstream.unwrap(numpy.pi, 16, 0.53)), 5)
          0.53125
  )");
}

void bind_predicted_variances(py::module_& module) {
  module.def("phase_variance",
             py::vectorize(py::overload_cast<int, double, double, double>(&phase_variance)),
             "steps"_a, "alpha"_a, "alpha_p"_a, "noise_variance"_a, R"(
      Predicted variance of a phase, Eq. (3.38).

      Args:
          steps (ArrayLike): phase steps of the sinusoid, 3 or more.
          alpha (ArrayLike): reflectivity, above 0 to 1.
          alpha_p (ArrayLike): amplitude of the patterns, grey levels of 255.
          noise_variance (ArrayLike): sigma_w^2, squared grey levels of 255.

      Returns:
          Any: rad^2.

      Example:
          >>> round(float(slipstream.phase_variance(4, 0.5, 255, 1.6)), 7)
          0.0001968
  )");

  module.def("coordinate_variance",
             py::vectorize(py::overload_cast<double, double>(&coordinate_variance)),
             "phase_variance"_a, "frequency"_a, R"(
      Predicted variance of the projector coordinate, Eq. (3.40).

      Args:
          phase_variance (ArrayLike): rad^2.
          frequency (ArrayLike): periods across the field.

      Returns:
          Any: squared fields.

      Example:
          >>> round(float(slipstream.coordinate_variance(1, 1)), 5)
          0.02533
  )");
}

void bind_geometry_calibration(py::module_& module) {
  module.def("calibrate_geometry", &calibrated, "folder"_a, "report"_a = py::none(), R"(
      Calibrates a scanner from scans of a board, one folder for each pose.

      Args:
          folder (str | PathLike): with one folder for each pose.
          report (str | PathLike | None): folder for report.html.
          board (Literal["chessboard", "circles", "charuco", "symmetric-circles"], default 'chessboard'):
              kind.
          columns (int, default 13): of corners or circles.
          rows (int, default 9): of corners or circles.
          spacing (float, default 10.0): side of a square, mm; for circles half the distance in a
              row.
          row_spacing (float | None, default None): between rows of a stretched print, mm; None: as
              `spacing`.
          circle_diameter (float | None, default None): spacings; None: 0.8, or 0.5 in a symmetric
              grid.
          marker_side (float, default 0.75): squares.
          marker_bits (int, default 4): of ArUco: 4 to 7 squared.
          sequence (Sequence | Strategy | str | None, default None): pattern sequence.
          first_axis (Literal["x", "y"], default 'x'): axis of the first frames if folders do not
              tell.
          excluded (typing.Sequence[str], default []): poses to ignore.
          minimum_modulation (float, default 5.0): least modulation of a pixel, grey levels of 255.
          neighbourhood (float, default 0.7): size of the region that locates a corner in the
              projector, spacings.
          response (Response | None, default None): from pattern values to light; None if unknown.
          camera_coefficients (int | None, default None): of distortion; None: as the data support.
          projector_coefficients (int | None, default None): of distortion; None: as the data
              support.
          print_deviation (float | None, default 0.01): standard deviation of a printed corner,
              spacings; None: the print is exact.

      Returns:
          CalibrationReport

      Raises:
          Error: if a pose is refused, or a value is out of range.
          TypeError: for an unknown keyword or a value of the wrong type.

      Example:
          >>> report = slipstream.calibrate_geometry("poses", columns=9, rows=6)  # doctest: +SKIP
  )");
}

}  // namespace

void bind_calibration(py::module_& module) {
  bind_report(module);

  // The photometry, from scans.
  bind_gamma_calibrations(module);
  bind_light_calibrations(module);

  // Phases, coordinates and their variances, on arrays.
  bind_phases(module);
  bind_predicted_variances(module);

  // The geometry, from a folder of poses.
  bind_geometry_calibration(module);
}

}  // namespace slipstream::python
