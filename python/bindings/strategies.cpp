#include <pybind11/operators.h>

#include "python/bindings/arrays.h"
#include "python/bindings/bindings.h"
#include "slipstream/io/pattern_pictures.h"
#include "slipstream/strategy/registry.h"
#include "slipstream/strategy/sequence.h"
#include "slipstream/strategy/strategy_design.h"

namespace slipstream::python {
namespace {

SettingValue setting_from(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>();
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::hasattr(value, "__len__")) return value.cast<std::vector<double>>();
  return value.cast<double>();
}

Strategy strategy_from(const std::string& name, const py::kwargs& settings) {
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

/// Name, words of help, which strategies have it with its default.
std::vector<std::tuple<std::string, std::string, std::string>> described_settings() {
  std::vector<std::tuple<std::string, std::string, std::string>> described;
  for (const SettingDescription& setting : strategy_settings()) {
    described.emplace_back(setting.name, setting.help, setting.strategies);
  }
  return described;
}

Sequence sequence_from(const Strategy& strategy, const std::string& axis,
                       std::optional<Size> projector, const PatternLight& light,
                       const Sequence& rest) {
  Sequence sequence = rest;
  sequence.strategy = strategy;
  sequence.projector = projector.value_or(Size{});
  sequence.light = light;
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
  {
    const py::gil_scoped_release release;
    for (int n = 0; n < patterns.count; ++n) {
      const Image<std::uint16_t> picture = render_pattern(patterns, n, sequence.projector, bits);
      at = std::copy(picture.begin(), picture.end(), at);
    }
  }
  if (bits > 8) return pictures;
  return pictures.attr("astype")("uint8");
}

std::string text_of(const Sequence& sequence) {
  return label_of(sequence.strategy) + " along " + std::string(axes_of(sequence)) + ", " +
         std::to_string(frame_count(sequence)) + " frames";
}

std::vector<std::filesystem::path> written_patterns(const Sequence& sequence,
                                                    const std::filesystem::path& folder, int bits) {
  return write_patterns(folder, pattern_set(cycle_of(sequence)), sequence, bits, [] {});
}

std::vector<StrategyDesign> designs(int frames, std::optional<double> coordinate_sigma,
                                    double alpha, double noise_variance, double success,
                                    int most_periods) {
  return strategy_designs({.frames = frames,
                           .coordinate_sigma = coordinate_sigma,
                           .alpha = alpha,
                           .noise_variance = noise_variance,
                           .success = success,
                           .most_periods = most_periods});
}

void bind_sequence(py::module_& module) {
  py::class_<Sequence>(module, "Sequence", "What a projector shows for one scan.")
      .def(py::init([](const Strategy& strategy, const std::string& axis,
                       std::optional<Size> projector, double alpha_p, double beta_p, bool marker,
                       std::vector<double> exposures, bool binary, int motion) {
             return sequence_from(strategy, axis, projector, {alpha_p, beta_p},
                                  {.marker = marker,
                                   .exposures = std::move(exposures),
                                   .binary = binary,
                                   .motion = motion});
           }),
           py::arg("strategy"), py::arg("axis") = "x", py::kw_only(),
           py::arg("projector") = py::none(), py::arg("alpha_p") = 255., py::arg("beta_p") = 0.,
           py::arg("marker") = false, py::arg("exposures") = std::vector<double>{1},
           py::arg("binary") = false, py::arg("motion") = 0)
      .def_readonly("strategy", &Sequence::strategy)
      .def_property_readonly("axis", [](const Sequence& of) { return axes_of(of); })
      .def_readonly("projector", &Sequence::projector, "Pixels, (width, height).")
      .def_property_readonly("alpha_p", [](const Sequence& of) { return of.light.alpha_p; })
      .def_property_readonly("beta_p", [](const Sequence& of) { return of.light.beta_p; })
      .def_readonly("marker", &Sequence::marker)
      .def_readonly("exposures", &Sequence::exposures)
      .def_readonly("binary", &Sequence::binary)
      .def_readonly("motion", &Sequence::motion)
      .def_property_readonly("frames", py::overload_cast<const Sequence&>(&frame_count),
                             "Frames of one scan.")
      .def("patterns", &patterns_of, py::arg("bits") = 8,
           "The pictures to project, frames x rows x columns: uint8, or uint16 of more bits.")
      .def("write_patterns", &written_patterns, py::arg("folder"), py::arg("bits") = 8,
           "Writes them as PNG with a scan.yaml that says what they are.")
      .def(py::self == py::self)
      .def("__repr__",
           [](const Sequence& of) { return "<slipstream.Sequence " + text_of(of) + ">"; });
}

}  // namespace

void bind_strategies(py::module_& module) {
  py::class_<Strategy>(module, "Strategy",
                       "A coding by its name and its settings, or by its label: "
                       "Strategy('pmp', steps=4).")
      .def(py::init(&strategy_from), py::arg("name"))
      .def_property_readonly("name", &Strategy::name)
      .def_property_readonly("settings", &settings_of, "As files and command lines write them.")
      .def_property_readonly("label", &label_of, "Name and settings in a line.")
      .def_property_readonly("frames", py::overload_cast<const Strategy&>(&frame_count),
                             "Frames of one scan.")
      .def_property_readonly("has_coordinate", py::overload_cast<const Strategy&>(&has_coordinate),
                             "Whether the frames alone give the projector coordinate.")
      .def(py::self == py::self)
      .def("__repr__",
           [](const Strategy& of) { return "<slipstream.Strategy " + label_of(of) + ">"; });
  py::implicitly_convertible<py::str, Strategy>();
  module.def("strategy_names", &strategy_names, "Names of all strategies.");
  module.def("strategy_settings", &described_settings,
             "Each setting: name, what it means, which strategies have it and their defaults.");
  bind_sequence(module);
  py::class_<StrategyDesign>(module, "StrategyDesign", "A strategy and what it promises.")
      .def_readonly("strategy", &StrategyDesign::strategy)
      .def_readonly("success", &StrategyDesign::success,
                    "Share of right fringe orders, each pixel by itself.")
      .def_readonly("coordinate_sigma", &StrategyDesign::coordinate_sigma,
                    "Standard deviation of the projector coordinate, fields.")
      .def("__repr__", [](const StrategyDesign& of) {
        return py::str("<slipstream.StrategyDesign {}: sigma {:.3g} fields>")
            .format(label_of(of.strategy), of.coordinate_sigma);
      });
  module.def("design", &designs, py::kw_only(), py::arg("frames") = 10,
             py::arg("coordinate_sigma") = py::none(), py::arg("alpha") = 0.5,
             py::arg("noise_variance") = 1.6, py::arg("success") = 0.999,
             py::arg("most_periods") = 64, py::call_guard<py::gil_scoped_release>(),
             "Of each kind of strategy the one of least noise within so many frames, or of fewest "
             "frames for that noise; the best first.");
}

}  // namespace slipstream::python
