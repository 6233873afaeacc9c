#include <cmath>
#include <limits>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "python/bindings/scans.h"
#include "slipstream/error/error.h"
#include "slipstream/gamma/blind.h"
#include "slipstream/gamma/correction.h"
#include "slipstream/noise/predicted_variance.h"
#include "slipstream/phase/phase_decoder.h"
#include "slipstream/photometry/ambient_calibration.h"
#include "slipstream/photometry/gamma_calibration.h"
#include "slipstream/photometry/noise_calibration.h"
#include "slipstream/unwrap/temporal_unwrapping.h"

namespace slipstream::python {
namespace {

ScanAverage average_of(const py::iterable& scans, bool of_gamma) {
  ScanAverage average;
  for (const py::handle scan : scans) {
    const Scan checked = checked_scan(scan, of_gamma);
    const auto name = py::isinstance<Scan>(scan) ? "scan" : py::str(scan).cast<std::string>();
    if (!of_gamma) require_ambient_measurable(checked, name);
    average.add(checked, name);
  }
  return average;
}

/// What scans say of the noise, by all measurements that they allow.
struct FoundNoise {
  double variance = 0, gain = 0;
  std::vector<NoiseMeasurement> measurements;
};

FoundNoise noise_of(const py::iterable& scans) {
  std::vector<NoiseScan> read;
  for (const py::handle scan : scans) read.emplace_back(checked_scan(scan, false));
  const py::gil_scoped_release release;
  FoundNoise found{.measurements = calibrate_noise(read)};
  const double trusted = found.measurements.front().variance;
  const NoiseLine line = noise_line(read).value_or(NoiseLine{.at_half = trusted});
  found.variance = line.at_half;
  found.gain = line.gain;
  return found;
}

void bind_gamma(py::module_& module) {
  py::class_<BlindGamma>(module, "BlindGamma", "Gamma as one scan tells it by itself.")
      .def_readonly("gamma", &BlindGamma::gamma, "The best found, also where it is refused.")
      .def_readonly("standard_error", &BlindGamma::standard_error)
      .def_readonly("pixels", &BlindGamma::pixels, "How many were asked.")
      .def_property_readonly(
          "refusal",
          [](const BlindGamma& of) { return of.accepted() ? "" : reason_of(of.refusal); },
          "Why it is not to be corrected by; empty where it is.")
      .def("__repr__", [](const BlindGamma& of) {
        return py::str("<slipstream.BlindGamma {:.4g}{}>")
            .format(of.gamma, of.accepted() ? "" : ", refused");
      });
  module.def(
      "find_gamma",
      [](const py::object& frames, int steps, int first, std::optional<int> bits) {
        const BorrowedFrames given = borrowed(frames, bits);
        const py::gil_scoped_release release;
        return find_gamma(given.views, first, steps);
      },
      py::arg("frames"), py::arg("steps"), py::arg("first") = 0, py::kw_only(),
      py::arg("bits") = py::none(), "Of the frames of one sinusoid, from frame `first` on.");
  py::class_<GammaCalibration>(module, "GammaCalibration", "Gamma by scans of any surface.")
      .def_readonly("steps", &GammaCalibration::steps)
      .def_readonly("fit", &GammaCalibration::fit)
      .def_readonly("misfit", &GammaCalibration::misfit,
                    "Phase error that the power law leaves, rad.")
      .def_property_readonly("response", &found_response,
                             "To be a scanner's; Error where scans do not tell.")
      .def("__repr__", [](const GammaCalibration& of) {
        return py::str("<slipstream.GammaCalibration gamma {:.4g}, misfit {:.2g} rad>")
            .format(of.fit.gamma, of.misfit);
      });
  module.def(
      "calibrate_gamma",
      [](const py::iterable& scans, double minimum_modulation) {
        const ScanAverage average = average_of(scans, true);
        const py::gil_scoped_release release;
        return calibrate_gamma(average, minimum_modulation);
      },
      py::arg("scans"), py::kw_only(), py::arg("minimum_modulation") = 0.,
      "From scans of one unmoved scene, or their paths, best of 8 steps or more.");
}

void bind_noise(py::module_& module) {
  py::class_<NoiseMeasurement>(module, "NoiseMeasurement", "sigma_w^2 by one equation.")
      .def_readonly("equation", &NoiseMeasurement::equation, "Of Liu 2010.")
      .def_readonly("method", &NoiseMeasurement::method)
      .def_readonly("variance", &NoiseMeasurement::variance, "Grey levels^2 of 255.")
      .def_readonly("standard_error", &NoiseMeasurement::standard_error)
      .def_readonly("reason", &NoiseMeasurement::reason, "Why it disagrees with the first.");
  py::class_<FoundNoise>(module, "NoiseCalibration", "The noise of a camera's frames.")
      .def_readonly("variance", &FoundNoise::variance,
                    "sigma_w^2 at half of full scale, grey levels^2 of 255.")
      .def_readonly("gain", &FoundNoise::gain, "By which it grows with each grey level.")
      .def_readonly("measurements", &FoundNoise::measurements, "The most trusted first.")
      .def("__repr__", [](const FoundNoise& of) {
        return py::str("<slipstream.NoiseCalibration variance {:.3g}, gain {:.3g}>")
            .format(of.variance, of.gain);
      });
  module.def("calibrate_noise", &noise_of, py::arg("scans"),
             "From scans of one unmoved scene, or their paths.");
  py::class_<AmbientEstimate>(module, "AmbientEstimate", "Ambient light, grey levels of 255.")
      .def_readonly("mode", &AmbientEstimate::mode, "Where most pixels are: a scanner's ambient.")
      .def_readonly("median", &AmbientEstimate::median)
      .def_readonly("mean", &AmbientEstimate::mean)
      .def_readonly("variance", &AmbientEstimate::variance)
      .def_readonly("pixels", &AmbientEstimate::pixels)
      .def("__repr__", [](const AmbientEstimate& of) {
        return py::str("<slipstream.AmbientEstimate {:.2f} of {} pixels>")
            .format(of.mode, of.pixels);
      });
  module.def(
      "calibrate_ambient",
      [](const py::iterable& scans, double least_alpha,
         const std::optional<MeasuredResponse>& measured) {
        const ScanAverage average = average_of(scans, false);
        const py::gil_scoped_release release;
        std::optional<Response> response;
        if (measured) response = measured->response;
        return calibrate_ambient(average, least_alpha, response).estimate;
      },
      py::arg("scans"), py::kw_only(), py::arg("least_alpha") = 0.5,
      py::arg("response") = py::none(),
      "From scans of a bright surface with many steps, or their paths.");
}

/// Mean, modulation and wrapped phase by Eqs. (1.3) to (1.7).
py::tuple phases_of(const py::object& frames, int steps, int first, std::optional<int> bits) {
  const BorrowedFrames given = borrowed(frames, bits);
  if (first < 0 || steps < 3 || first + steps > given.views.count()) {
    throw Error("frames " + std::to_string(first) + " to " + std::to_string(first + steps - 1) +
                " of " + std::to_string(given.views.count()) + "; 3 steps or more are wanted");
  }
  PhaseMaps maps;
  {
    const py::gil_scoped_release release;
    maps = PhaseDecoder(PhaseMethod::equation, {steps})(given.views, first, steps);
  }
  return py::make_tuple(array_from(std::move(maps.mean)), array_from(std::move(maps.modulation)),
                        array_from(std::move(maps.wrapped_phase)));
}

double unwrapped(double wrapped_phase, double frequency, double coarse_coordinate) {
  if (!std::isfinite(wrapped_phase) || !std::isfinite(coarse_coordinate)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  const int order = fringe_order(wrapped_phase, frequency, coarse_coordinate);
  return unwrapped_coordinate(wrapped_phase, order, frequency);
}

}  // namespace

void bind_photometry(py::module_& module) {
  bind_gamma(module);
  bind_noise(module);
  module.def("phases", &phases_of, py::arg("frames"), py::arg("steps"), py::arg("first") = 0,
             py::kw_only(), py::arg("bits") = py::none(),
             "Mean, modulation and wrapped phase (rad, 0 to 2 pi) of N-step frames, in double.");
  module.def(
      "unwrap", py::vectorize(&unwrapped), py::arg("wrapped_phase"), py::arg("frequency"),
      py::arg("coarse_coordinate"),
      "Projector coordinate by the fringe order that is nearest to a coarse one, Eq. (1.17).");
  module.def("phase_variance",
             py::vectorize(py::overload_cast<int, double, double, double>(&phase_variance)),
             py::arg("steps"), py::arg("alpha"), py::arg("alpha_p"), py::arg("noise_variance"),
             "rad^2, of N steps at a reflectivity: Eq. (3.38).");
  module.def("coordinate_variance",
             py::vectorize(py::overload_cast<double, double>(&coordinate_variance)),
             py::arg("phase_variance"), py::arg("frequency"), "fields^2: Eq. (3.40).");
}

}  // namespace slipstream::python
