#include "python/bindings/scanners.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include <pybind11/eigen.h>
#include <pybind11/operators.h>

#include "codes/design.h"
#include "decode/phase_decoder.h"
#include "io/pattern_pictures.h"
#include "python/bindings/arguments.h"
#include "response/correction.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"

namespace slipstream::python {
namespace {

void take(Keywords& keywords, Lens& lens, const std::string& device) {
  std::vector<double> distortion;
  keywords.need((device + "_matrix").c_str(), lens.intrinsic);
  keywords.take((device + "_distortion").c_str(), distortion);
  keywords.need((device + "_size").c_str(), lens.size);

  lens.distortion = make_distortion(distortion);
}

Scanner scanner_from(const py::kwargs& given) {
  Keywords keywords(given);
  Scanner scanner;
  take(keywords, scanner.camera, "camera");
  take(keywords, scanner.projector, "projector");

  keywords.need("rotation", scanner.rotation);
  keywords.need("translation", scanner.translation);
  keywords.require_none_left();

  require_valid(scanner);
  return scanner;
}

template <auto Device>
void bind_lens(py::class_<Scanner>& scanner, const std::string& device) {
  const auto distortion = [](const Scanner& of) { return (of.*Device).distortion.coefficients; };

  scanner.def_property_readonly((device + "_matrix").c_str(), within(Device, &Lens::intrinsic),
                                "NDArray[float64]: 3 x 3, pixels.");
  scanner.def_property_readonly((device + "_distortion").c_str(), distortion,
                                "list[float]: OpenCV's coefficients.");
  scanner.def_property_readonly((device + "_size").c_str(), within(Device, &Lens::size),
                                "tuple[int, int]: width and height, pixels.");
}

template <auto Member>
void bind_photometry(py::class_<Scanner>& scanner, const char* name, const char* docstring) {
  scanner.def_property(
      name, [](const Scanner& of) { return of.photometry.*Member; },
      [](Scanner& of, std::decay_t<decltype(PhotometricCalibration().*Member)> value) {
        // On a copy, so that an invalid value changes nothing.
        PhotometricCalibration changed = of.photometry;
        changed.*Member = std::move(value);
        require_valid(changed);
        of.photometry = changed;
      },
      docstring);
}

/// The phases of any shape, corrected.
py::object corrected_phases(const MeasuredResponse& of, const py::array_t<double>& phases,
                            int steps) {
  const PhaseCorrection correction = phase_correction(of.response, steps);
  return py::vectorize([&](double phase) { return corrected_phase(correction, phase); })(phases);
}

void bind_response(py::module_& module) {
  py::class_<MeasuredResponse> response(module, "Response", R"(
      Response of light to pattern values: a power law, or a curve near one.

      Args:
          gamma (float): exponent.

      Example:
          >>> slipstream.Response(2.2).gamma
          2.2
  )");

  response.def(py::init([](double gamma) {
                 require_gamma(gamma, "gamma");
                 return MeasuredResponse{PowerLaw{gamma}, gamma};
               }),
               "gamma"_a);
  response.def(py::self == py::self);

  response.def_readonly("gamma", &MeasuredResponse::gamma, "float: exponent.");
  response.def_readonly("standard_error", &MeasuredResponse::standard_error,
                        "float: of the estimate.");

  response.def("corrected", &corrected_phases, "phases"_a, "steps"_a, R"(
      Wrapped phases of N-step patterns, corrected for this response.

      Args:
          phases (ArrayLike): rad, any shape.
          steps (int): phase steps of the sinusoid, 3 or more.

      Returns:
          Any: rad, same shape.

      Example:
          >>> slipstream.Response(2.2).corrected([0.0, 1.0], 3).shape
          (2,)
  )");
}

void bind_scanner_properties(py::class_<Scanner>& scanner) {
  bind_lens<&Scanner::camera>(scanner, "camera");
  bind_lens<&Scanner::projector>(scanner, "projector");

  bind_photometry<&PhotometricCalibration::ambient>(
      scanner, "ambient", "float | None: grey levels of 255; None if unknown.");
  bind_photometry<&PhotometricCalibration::noise_variance>(
      scanner, "noise_variance",
      "float | None: sigma_w^2, squared grey levels of 255; None if unknown.");
  bind_photometry<&PhotometricCalibration::noise_gain>(scanner, "noise_gain",
                                                       "float: noise variance per grey level.");
  bind_photometry<&PhotometricCalibration::response>(
      scanner, "response", "Response | None: from pattern values to light; None if unknown.");

  scanner.def_readonly("rotation", &Scanner::rotation,
                       "NDArray[float64]: to the projector's frame, 3 x 3.");
  scanner.def_readonly("translation", &Scanner::translation,
                       "NDArray[float64]: to the projector's frame, mm.");
  scanner.def_readwrite("measured", &Scanner::measured,
                        "str: how and when it was calibrated, as text.");
}

void bind_scanner(py::module_& module) {
  py::class_<Scanner> scanner(module, "Scanner", R"(
      Calibration of a camera and a projector; the world frame is the camera's, in mm.

      Args:
          camera_matrix (ArrayLike): 3 x 3, pixels.
          camera_size (tuple[int, int]): width and height, pixels.
          projector_matrix (ArrayLike): 3 x 3, pixels.
          projector_size (tuple[int, int]): width and height, pixels.
          rotation (ArrayLike): to the projector's frame, 3 x 3.
          translation (ArrayLike): to the projector's frame, mm.
          camera_distortion (typing.Sequence[float], default []): OpenCV's coefficients: 0, 1, 2,
              4, 5, 8 or 12.
          projector_distortion (typing.Sequence[float], default []): as `camera_distortion`.

      Example:
          >>> slipstream.example_scanner((320, 240)).camera_size
          (320, 240)
  )");

  scanner.def(py::init(&scanner_from));
  scanner.def(py::self == py::self);
  bind_scanner_properties(scanner);

  const auto write = [](const Scanner& of, const fs::path& path) { write_scanner(path, of); };

  scanner.def("write", write, "path"_a, Unlocked(), R"(
      Writes a scanner file.

      Args:
          path (str | PathLike): .yaml or .xml.

      Raises:
          Error: if the ending is not supported.
          WorldError: if the file cannot be written.

      Example:
          >>> scan.scanner.write("scanner.yaml")
  )");
}

void bind_scanner_sources(py::module_& module) {
  module.def("load_scanner", &read_scanner, "path"_a, Unlocked(), R"(
      Reads a scanner from an OpenCV file (YAML or XML) or a recording.

      Args:
          path (str | PathLike): file, by its ending.

      Returns:
          Scanner

      Raises:
          Error: if the file is missing or malformed, or its ending not supported.
          WorldError: if it cannot be read.

      Example:
          >>> scan.scanner.write("scanner.xml")
          >>> scanner = slipstream.load_scanner("scanner.xml")
  )");

  module.def("example_scanner", &example_scanner, "camera"_a = Size{640, 480}, R"(
      A camera beside a 1280x800 projector, for the virtual world.

      Args:
          camera (tuple[int, int]): width and height, pixels.

      Returns:
          Scanner

      Example:
          >>> slipstream.example_scanner().camera_size
          (640, 480)
  )");
}

}  // namespace

void bind_scanners(py::module_& module) {
  bind_response(module);
  bind_scanner(module);
  bind_scanner_sources(module);
}

}  // namespace slipstream::python
