#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include <pybind11/eigen.h>
#include <pybind11/operators.h>

#include "base/throw_if-inl.h"
#include "codes/design.h"
#include "decode/phase_decoder.h"
#include "io/pattern_pictures.h"
#include "python/bindings/arguments.h"
#include "python/bindings/bindings.h"
#include "response/correction.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scanner_file.h"
#include "slipstream/strategy.h"

namespace slipstream::python {
namespace {

using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

Array array_of_numbers(const std::string& name, const py::object& given) {
  Array array = Array::ensure(given);
  if (!array)
    throw py::type_error(fmt::format("{} cannot be {}; expected numbers", name, shown(given)));
  return array;
}

/// 3 x 3. Throws Error for another shape.
Eigen::Matrix3d matrix_from(const std::string& name, const py::object& given) {
  const Array array = array_of_numbers(name, given);

  if (array.ndim() != 2 || array.shape(0) != 3 || array.shape(1) != 3) {
    const bool is_vector = name == "rotation" && array.size() == 3;
    throw Error(fmt::format("{}: {}; expected shape (3, 3){}", name, shown(array),
                            is_vector ? ", as cv2.Rodrigues(rotation)[0]" : ""));
  }

  Eigen::Matrix3d matrix;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) matrix(row, column) = array.at(row, column);
  }
  return matrix;
}

/// A row or a column, as OpenCV has both, or one dimension; empty for None. Throws Error for
/// another shape.
std::vector<double> numbers_from(const std::string& name, const py::object& given) {
  if (given.is_none()) return {};
  const Array array = array_of_numbers(name, given);

  const bool is_vector =
      array.ndim() == 1 || (array.ndim() == 2 && (array.shape(0) == 1 || array.shape(1) == 1));
  throw_if(!is_vector, "{}: {}; expected shape (N,), (N, 1) or (1, N)", name, shown(array));
  return {array.data(), array.data() + array.size()};
}

Distortion distortion_from(const std::string& name, const py::object& given) {
  const std::vector<double> coefficients = numbers_from(name, given);
  try {
    return make_distortion(coefficients);
  } catch (const Error& error) {
    throw Error(name + ": " + error.what());
  }
}

Eigen::Vector3d translation_from(const py::object& given) {
  const std::vector<double> numbers = numbers_from("translation", given);
  throw_if(numbers.size() != 3, "translation: {}; expected 3 numbers", shown(given));
  return Eigen::Vector3d(numbers.data());
}

void take(Keywords& keywords, Lens& lens, const std::string& device) {
  py::object matrix;
  py::object distortion = py::none();
  keywords.need((device + "_matrix").c_str(), matrix);
  keywords.take((device + "_distortion").c_str(), distortion);
  keywords.need((device + "_size").c_str(), lens.size);

  lens.intrinsic = matrix_from(device + "_matrix", matrix);
  lens.distortion = distortion_from(device + "_distortion", distortion);
}

Scanner scanner_from(const py::kwargs& kwargs) {
  Keywords keywords(kwargs);
  Scanner scanner;
  take(keywords, scanner.camera, "camera");
  take(keywords, scanner.projector, "projector");

  py::object rotation, translation;
  keywords.need("rotation", rotation);
  keywords.need("translation", translation);
  keywords.require_none_left();

  scanner.rotation = matrix_from("rotation", rotation);
  scanner.translation = translation_from(translation);

  require_valid(scanner);
  return scanner;
}

/// From results of cv2.stereoCalibrate in its order; `camera_matrix` may hold all of them.
Scanner scanner_from_opencv(const py::object& camera_matrix, const py::object& camera_distortion,
                            const py::object& projector_matrix,
                            const py::object& projector_distortion, const py::object& rotation,
                            const py::object& translation, Size camera_size, Size projector_size) {
  std::vector<std::pair<const char*, py::object>> named{
      {"camera_matrix", camera_matrix},
      {"camera_distortion", camera_distortion},
      {"projector_matrix", projector_matrix},
      {"projector_distortion", projector_distortion},
      {"rotation", rotation},
      {"translation", translation}};

  // All results: the RMS comes before the values that are named here, E and F come after them.
  constexpr std::size_t result_count = 9;
  if (py::isinstance<py::tuple>(camera_matrix) && py::len(camera_matrix) >= result_count) {
    // Other functions of OpenCV, as of fisheye lenses, give other values at their place.
    const auto all = camera_matrix.cast<py::tuple>();
    for (const std::size_t i : {result_count - 2, result_count - 1}) {
      const auto matrix = py::array::ensure(all[i]);
      throw_if(!matrix || matrix.ndim() != 2 || matrix.shape(0) != 3 || matrix.shape(1) != 3,
               "camera_matrix: {} results without E and F, 3 x 3; expected all results of "
               "cv2.stereoCalibrate: RMS, K1, d1, K2, d2, R, T, E, F",
               all.size());
    }

    for (std::size_t i = 0; i < named.size(); ++i) {
      auto& [name, value] = named[i];
      throw_if(i > 0 && !value.is_none(), "{}: the results of cv2.stereoCalibrate have it already",
               name);
      value = all[i + 1];
    }
  }

  // Those left out are missing, except a distortion.
  py::dict given("camera_size"_a = camera_size, "projector_size"_a = projector_size);
  for (const auto& [name, value] : named) {
    if (!value.is_none()) given[name] = value;
  }
  return scanner_from(given);
}

template <auto Device>
void bind_lens(py::class_<Scanner>& scanner, const std::string& device) {
  const auto distortion = [](const Scanner& self) {
    return (self.*Device).distortion.coefficients;
  };

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
      name, [](const Scanner& self) { return self.photometry.*Member; },
      [](Scanner& self, std::decay_t<decltype(PhotometricCalibration().*Member)> value) {
        // On a copy, so that an invalid value changes nothing.
        PhotometricCalibration changed = self.photometry;
        changed.*Member = std::move(value);
        require_valid(changed);
        self.photometry = changed;
      },
      docstring);
}

/// The phases of any shape, corrected.
py::object corrected_phases(const MeasuredResponse& self, const py::array_t<double>& phases,
                            int steps) {
  const PhaseCorrection correction = phase_correction(self.response, steps);
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

void bind_opencv(py::class_<Scanner>& scanner) {
  const py::none none;
  scanner.def_static("from_opencv", &scanner_from_opencv, "camera_matrix"_a,
                     "camera_distortion"_a = none, "projector_matrix"_a = none,
                     "projector_distortion"_a = none, "rotation"_a = none, "translation"_a = none,
                     py::kw_only(), "camera_size"_a, "projector_size"_a, R"(
      A scanner from the results of `cv2.stereoCalibrate`.

      Its first device, `imagePoints1`, must be the camera and its second one, `imagePoints2`, the
      projector, so that R and T lead from the camera's frame to the projector's. If the projector
      was the first, exchange both and give `R.T` and `-R.T @ T`. The board must have been described
      in mm.

      Args:
          camera_matrix (ArrayLike | tuple[Any, ...]): K1, 3 x 3, pixels; or all results at once:
              RMS, K1, d1, K2, d2, R, T, E, F.
          camera_distortion (ArrayLike | None): d1, 4, 5, 8, 12 or 14 coefficients in a row or
              column; None: without distortion.
          projector_matrix (ArrayLike | None): K2, 3 x 3, pixels.
          projector_distortion (ArrayLike | None): d2, as `camera_distortion`.
          rotation (ArrayLike | None): R, 3 x 3.
          translation (ArrayLike | None): T, mm, 3 x 1.
          camera_size (tuple[int, int]): width and height, pixels.
          projector_size (tuple[int, int]): width and height, pixels.

      Returns:
          Scanner

      Raises:
          Error: if an array has the wrong shape, or a value is out of range.

      Example:
          >>> one = scan.scanner
          >>> results = (one.camera_matrix, one.camera_distortion, one.projector_matrix,
          ...            one.projector_distortion, one.rotation, one.translation)
          >>> slipstream.Scanner.from_opencv(*results, camera_size=(160, 120),
          ...                                projector_size=(1280, 800)).camera_size
          (160, 120)
  )");
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
          translation (ArrayLike): to the projector's frame, mm, 3, 3 x 1 or 1 x 3.
          camera_distortion (ArrayLike | None, default None): OpenCV's 4, 5, 8, 12 or 14
              coefficients in a row or column; None: without distortion.
          projector_distortion (ArrayLike | None, default None): as `camera_distortion`.

      Example:
          >>> slipstream.example_scanner((320, 240)).camera_size
          (320, 240)
  )");

  scanner.def(py::init(&scanner_from));
  scanner.def(py::self == py::self);
  bind_scanner_properties(scanner);
  bind_opencv(scanner);

  const auto write = [](const Scanner& self, const fs::path& path) { write_scanner(path, self); };

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
