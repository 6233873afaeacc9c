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

SettingValue setting_from(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::hasattr(value, "__len__")) return value.cast<std::vector<double>>();
  return value.cast<double>();
}

Strategy strategy_from(const std::string& name, const py::kwargs& settings) {
  // A name alone may be a label, which contains settings.
  if (settings.empty()) return strategy_labelled(name);

  StrategySettings values;
  for (const auto& [setting, value] : settings) {
    if (!value.is_none()) values[setting.cast<std::string>()] = setting_from(value);
  }

  return make_strategy(name, values);
}

py::dict settings_of(const Strategy& strategy) {
  py::dict settings;
  for (const auto& [name, value] : strategy.settings()) settings[py::str(name)] = value.text();
  return settings;
}

std::vector<std::array<std::string, 3>> described_settings() {
  std::vector<std::array<std::string, 3>> described;
  for (const auto& of : strategy_settings()) described.push_back({of.name, of.help, of.strategies});
  return described;
}

Sequence sequence_from(const Strategy& strategy, const std::string& axis, const py::kwargs& given) {
  Sequence sequence{.strategy = strategy};
  Keywords keywords(given);
  keywords.take("projector", sequence.projector, "alpha_p", sequence.light.alpha_p, "beta_p",
                sequence.light.beta_p, "marker", sequence.marker, "exposures", sequence.exposures,
                "binary", sequence.binary, "motion", sequence.motion);
  keywords.require_none_left();

  set_axes(sequence, axis);
  require_valid(sequence.light);
  require_mergeable(sequence);
  require_shown(sequence);

  return sequence;
}

py::array patterns_of(const Sequence& sequence, int bits) {
  const PatternSet patterns = pattern_set(cycle_of(sequence));
  const auto [width, height] = sequence.projector;

  py::array_t<std::uint16_t> pictures({patterns.count, height, width});
  std::uint16_t* at = pictures.mutable_data();

  unlocked([&] {
    for (int n = 0; n < patterns.count; ++n) {
      const Image<std::uint16_t> picture = render_pattern(patterns, n, sequence.projector, bits);
      at = std::ranges::copy(picture, at).out;
    }
  });

  return bits > 8 ? pictures : pictures.attr("astype")("uint8");
}

py::list designs(const py::kwargs& given) {
  StrategyGoal goal;
  Keywords keywords(given);
  keywords.take("frames", goal.frames, "coordinate_sigma", goal.coordinate_sigma, "alpha",
                goal.alpha, "noise_variance", goal.noise_variance, "success", goal.success,
                "most_periods", goal.most_periods);
  keywords.require_none_left();

  py::list found;
  for (const auto& [strategy, success, sigma] : unlocked([&] { return strategy_designs(goal); })) {
    found.append(
        results("strategy"_a = strategy, "success"_a = success, "coordinate_sigma"_a = sigma));
  }

  return found;
}

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
void add_lens(py::class_<Scanner>& scanner, const std::string& device) {
  const auto distortion = [](const Scanner& of) { return (of.*Device).distortion.coefficients; };
  add(scanner, (device + "_matrix").c_str(), within(Device, &Lens::intrinsic),
      (device + "_distortion").c_str(), distortion, (device + "_size").c_str(),
      within(Device, &Lens::size));
}

template <auto Member>
void add_photometry(py::class_<Scanner>& scanner, const char* name) {
  scanner.def_property(
      name, [](const Scanner& of) { return of.photometry.*Member; },
      [](Scanner& of, std::decay_t<decltype(PhotometricCalibration().*Member)> value) {
        // On a copy, so that an invalid value changes nothing.
        PhotometricCalibration changed = of.photometry;
        changed.*Member = std::move(value);
        require_valid(changed);
        of.photometry = changed;
      });
}

void bind_strategies(py::module_& module) {
  py::class_<Strategy> strategy(module, "Strategy");
  strategy.def(py::init(&strategy_from), "name"_a).def(py::self == py::self);

  add(strategy, "name", &Strategy::name, "settings", &settings_of, "label", &label_of, "frames",
      py::overload_cast<const Strategy&>(&frame_count), "has_coordinate",
      py::overload_cast<const Strategy&>(&has_coordinate));

  py::implicitly_convertible<py::str, Strategy>();

  module.def("strategy_names", &strategy_names);
  module.def("strategy_settings", &described_settings);
  module.def("design", &designs);

  py::class_<Sequence> sequence(module, "Sequence");
  sequence.def(py::init(&sequence_from), "strategy"_a, "axis"_a = "x").def(py::self == py::self);

  add(sequence, "strategy", &Sequence::strategy, "axis", &axes_of, "projector",
      &Sequence::projector, "marker", &Sequence::marker, "exposures", &Sequence::exposures,
      "binary", &Sequence::binary, "motion", &Sequence::motion, "frames",
      py::overload_cast<const Sequence&>(&frame_count), "alpha_p",
      within(&Sequence::light, &PatternLight::alpha_p), "beta_p",
      within(&Sequence::light, &PatternLight::beta_p));

  sequence.def("patterns", &patterns_of, "bits"_a = 8);

  sequence.def(
      "write_patterns",
      [](const Sequence& of, const fs::path& folder, int bits) {
        return write_patterns(folder, pattern_set(cycle_of(of)), of, bits, [] {});
      },
      "folder"_a, "bits"_a = 8, Unlocked());
}

void bind_responses(py::module_& module) {
  py::class_<MeasuredResponse> response(module, "Response");
  response.def(py::init([](double gamma) {
                 require_gamma(gamma, "gamma");
                 return MeasuredResponse{PowerLaw{gamma}, gamma};
               }),
               "gamma"_a);

  add(response, "gamma", &MeasuredResponse::gamma, "standard_error",
      &MeasuredResponse::standard_error);

  response.def(py::self == py::self);

  // A phase array of any shape.
  response.def(
      "corrected",
      [](const MeasuredResponse& of, const py::array_t<double>& phases, int steps) {
        const PhaseCorrection correction = phase_correction(of.response, steps);
        return py::vectorize([&](double phase) { return corrected_phase(correction, phase); })(
            phases);
      },
      "phases"_a, "steps"_a);
}

}  // namespace

void bind_scanners(py::module_& module) {
  bind_strategies(module);
  bind_responses(module);

  py::class_<Scanner> scanner(module, "Scanner");
  scanner.def(py::init(&scanner_from)).def(py::self == py::self);

  add_lens<&Scanner::camera>(scanner, "camera");
  add_lens<&Scanner::projector>(scanner, "projector");

  add_photometry<&PhotometricCalibration::ambient>(scanner, "ambient");
  add_photometry<&PhotometricCalibration::noise_variance>(scanner, "noise_variance");
  add_photometry<&PhotometricCalibration::noise_gain>(scanner, "noise_gain");
  add_photometry<&PhotometricCalibration::response>(scanner, "response");

  add(scanner, "rotation", &Scanner::rotation, "translation", &Scanner::translation);
  scanner.def_readwrite("measured", &Scanner::measured);

  scanner.def(
      "write", [](const Scanner& of, const fs::path& path) { write_scanner(path, of); }, "path"_a,
      Unlocked());

  module.def("load_scanner", &read_scanner, "path"_a, Unlocked());
  module.def("example_scanner", &example_scanner, "camera"_a = Size{640, 480});
}

}  // namespace slipstream::python
