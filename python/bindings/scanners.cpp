#include <pybind11/eigen.h>
#include <pybind11/operators.h>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "slipstream/gamma/correction.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream::python {
namespace {

Scanner scanner_from(const Eigen::Matrix3d& camera_matrix, Size camera_size,
                     const Eigen::Matrix3d& projector_matrix, Size projector_size,
                     const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation,
                     const std::vector<double>& camera_distortion,
                     const std::vector<double>& projector_distortion) {
  const Scanner scanner{
      .camera = {camera_matrix, make_distortion(camera_distortion), camera_size},
      .projector = {projector_matrix, make_distortion(projector_distortion), projector_size},
      .rotation = rotation,
      .translation = translation};
  require_valid(scanner);
  return scanner;
}

template <auto Member>
void add_lens(py::class_<Scanner>& scanner, const std::string& device) {
  scanner
      .def_property_readonly((device + "_matrix").c_str(),
                             [](const Scanner& of) { return (of.*Member).intrinsic; })
      .def_property_readonly((device + "_distortion").c_str(),
                             [](const Scanner& of) { return (of.*Member).distortion.coefficients; })
      .def_property_readonly((device + "_size").c_str(),
                             [](const Scanner& of) { return (of.*Member).size; });
}

template <auto Member>
void add_photometry(py::class_<Scanner>& scanner, const char* name, const char* help) {
  scanner.def_property(
      name, [](const Scanner& of) { return of.photometry.*Member; },
      [](Scanner& of, std::decay_t<decltype(PhotometricCalibration().*Member)> value) {
        PhotometricCalibration changed = of.photometry;
        changed.*Member = std::move(value);
        require_valid(changed);
        of.photometry = changed;
      },
      help);
}

Scanner loaded_scanner(const std::filesystem::path& path, std::optional<Size> camera,
                       std::optional<Size> projector) {
  Scanner scanner = read_scanner(path);
  if (!camera && !projector) return scanner;
  return completed(std::move(scanner), path.string(), camera.value_or(Size{}),
                   projector.value_or(Size{}));
}

MeasuredResponse power_law(double gamma) {
  require_gamma(gamma, "gamma");
  return {PowerLaw{gamma}, gamma};
}

void bind_responses(py::module_& module) {
  py::class_<MeasuredResponse>(module, "Response",
                               "How light answers a pattern's value: a power law, or a curve.")
      .def(py::init(&power_law), py::arg("gamma"))
      .def_readonly("gamma", &MeasuredResponse::gamma, "Of the power law, or of the one nearest.")
      .def_readonly("standard_error", &MeasuredResponse::standard_error)
      .def(
          "light",
          [](const MeasuredResponse& of, const py::array_t<double>& values) {
            return py::vectorize([&](double value) { return light_at(of.response, value); })(
                values);
          },
          py::arg("values"), "Light, 0 to 1, at values of the pattern, 0 to 1.")
      .def(
          "corrected",
          [](const MeasuredResponse& of, const py::array_t<double>& phases, int steps) {
            const PhaseCorrection correction = phase_correction(of.response, steps);
            return py::vectorize([&](double phase) { return corrected_phase(correction, phase); })(
                phases);
          },
          py::arg("phases"), py::arg("steps"),
          "Wrapped phases, rad, that so many steps measured, without what the response did.")
      .def(py::self == py::self)
      .def("__repr__", [](const MeasuredResponse& of) {
        return py::str("<slipstream.Response {} {:.4g}>")
            .format(std::holds_alternative<PowerLaw>(of.response) ? "gamma" : "curve near gamma",
                    of.gamma);
      });
}

}  // namespace

void bind_scanners(py::module_& module) {
  bind_responses(module);
  py::class_<Scanner> scanner(module, "Scanner",
                              "All that calibration knows of a camera and a projector; mm, the "
                              "world is the camera's frame. Sizes are (width, height).");
  scanner.def(py::init(&scanner_from), py::kw_only(), py::arg("camera_matrix"),
              py::arg("camera_size"), py::arg("projector_matrix"), py::arg("projector_size"),
              py::arg("rotation"), py::arg("translation"),
              py::arg("camera_distortion") = std::vector<double>{},
              py::arg("projector_distortion") = std::vector<double>{});
  add_lens<&Scanner::camera>(scanner, "camera");
  add_lens<&Scanner::projector>(scanner, "projector");
  add_photometry<&PhotometricCalibration::ambient>(scanner, "ambient",
                                                   "Ambient light, grey levels of 255, or None.");
  add_photometry<&PhotometricCalibration::noise_variance>(
      scanner, "noise_variance", "sigma_w^2 at half of full scale, grey levels^2 of 255, or None.");
  add_photometry<&PhotometricCalibration::noise_gain>(scanner, "noise_gain",
                                                      "By which it grows with each grey level.");
  add_photometry<&PhotometricCalibration::response>(scanner, "response",
                                                    "That phases are corrected for, or None.");
  scanner.def_readonly("rotation", &Scanner::rotation)
      .def_readonly("translation", &Scanner::translation)
      .def_property_readonly(
          "calibrated_depths",
          [](const Scanner& of) -> std::optional<std::pair<double, double>> {
            if (!of.calibrated_depths) return std::nullopt;
            return std::pair(of.calibrated_depths->nearest, of.calibrated_depths->farthest);
          },
          "Between which the boards stood, mm, or None.")
      .def_readwrite("measured", &Scanner::measured, "How and when, for people.")
      .def(
          "write",
          [](const Scanner& of, const std::filesystem::path& path) { write_scanner(path, of); },
          py::arg("path"), "Writes a scanner file: .yaml or .xml.")
      .def(py::self == py::self)
      .def("__repr__", [](const Scanner& of) {
        return py::str("<slipstream.Scanner camera {}, projector {}, baseline {:.1f} mm>")
            .format(text_of(of.camera.size), text_of(of.projector.size), of.translation.norm());
      });
  module.def("load_scanner", &loaded_scanner, py::arg("path"), py::kw_only(),
             py::arg("camera_size") = py::none(), py::arg("projector_size") = py::none(),
             py::call_guard<py::gil_scoped_release>(),
             "The scanner of an OpenCV file (YAML or XML) in slipstream's layout or another's, or "
             "of a recording; with sizes where the file does not say them.");
  module.def("example_scanner", &example_scanner, py::arg("camera") = Size{640, 480},
             "A camera of that size beside a projector of 1280x800, for the virtual world.");
}

}  // namespace slipstream::python
