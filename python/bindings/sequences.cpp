#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <pybind11/operators.h>

#include "codes/design.h"
#include "io/pattern_pictures.h"
#include "python/bindings/arguments.h"
#include "python/bindings/bindings.h"
#include "python/bindings/given.h"
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
  for (const auto& setting : strategy_settings())
    described.push_back({setting.name, setting.help, setting.strategies});
  return described;
}

Sequence sequence_from(const Given<Strategy>& strategy, const std::string& axis,
                       const py::kwargs& kwargs) {
  Sequence sequence{.strategy = strategy.value};
  Keywords keywords(kwargs);
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

py::list designs(const py::kwargs& kwargs) {
  StrategyGoal goal;
  Keywords keywords(kwargs);
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

void bind_strategy(py::module_& module) {
  py::class_<Strategy> strategy(module, "Strategy", R"(
      A coding of the projector's coordinate in patterns.

      Args:
          name (str): with settings as keywords, or a label alone.
          **settings (float | str | typing.Sequence[float] | None): values by name, see
              `strategy_settings`.

      Raises:
          Error: for an unknown name or setting.

      Example:
          >>> slipstream.Strategy("pmp", steps=4).frames
          4
  )");

  strategy.def(py::init(&strategy_from), "name"_a);
  strategy.def(py::self == py::self);

  strategy.def_property_readonly("name", &Strategy::name, "str: name without settings.");
  strategy.def_property_readonly("settings", &settings_of,
                                 "dict[str, str]: values by name, see `strategy_settings`.");
  strategy.def_property_readonly("label", &label_of,
                                 "str: name and settings; makes an equal strategy.");
  strategy.def_property_readonly("frames", py::overload_cast<const Strategy&>(&frame_count),
                                 "int: number of frames of a scan.");
  strategy.def_property_readonly("has_coordinate",
                                 py::overload_cast<const Strategy&>(&has_coordinate),
                                 "bool: whether it gives an absolute coordinate.");
}

void bind_strategy_lists(py::module_& module) {
  module.def("strategy_names", &strategy_names, R"(
      Names of all strategies.

      Returns:
          list[str]

      Example:
          >>> "pmp" in slipstream.strategy_names()
          True
  )");

  module.def("strategy_settings", &described_settings, R"(
      Each setting: name, description, and the strategies that have it with defaults.

      Returns:
          list[tuple[str, str, str]]: by setting.

      Example:
          >>> slipstream.strategy_settings()[0][0]
          'steps'
  )");

  module.def("design", &designs, R"(
      The best setting of each kind of strategy, best first.

      Args:
          frames (int, default 10): most frames of a scan, 3 to 64.
          coordinate_sigma (float | None, default None): sufficient for the coordinate, fields;
              None: the least possible.
          alpha (float, default 0.5): reflectivity, above 0 to 1.
          noise_variance (float, default 1.6): sigma_w^2, squared grey levels of 255.
          success (float, default 0.999): share of correct fringe orders.
          most_periods (int, default 64): most that projector and lenses resolve, 2 to 1000.

      Returns:
          list[SimpleNamespace]: proposals.
              strategy (Strategy): proposal.
              success (float): share of correct fringe orders.
              coordinate_sigma (float): standard deviation of the coordinate, fields.

      Example:
          >>> slipstream.design(frames=6)[0].strategy.frames <= 6
          True
  )");
}

void bind_sequence_properties(py::class_<Sequence>& sequence) {
  sequence.def_readonly("strategy", &Sequence::strategy, "Strategy: coding.");
  sequence.def_property_readonly("axis", &axes_of, "str: direction of the coordinate.");
  sequence.def_readonly("projector", &Sequence::projector,
                        "tuple[int, int]: width and height, pixels; (0, 0) if unknown.");
  sequence.def_readonly("marker", &Sequence::marker, "bool: a dark frame ends each cycle.");
  sequence.def_readonly("exposures", &Sequence::exposures, "list[float]: relative, any unit.");
  sequence.def_readonly("binary", &Sequence::binary,
                        "bool: dithered to 1 bit, for DMD projectors.");
  sequence.def_readonly("motion", &Sequence::motion,
                        "int: extra frames per cloud for motion compensation: 0, 2 or 4.");
  sequence.def_property_readonly("frames", py::overload_cast<const Sequence&>(&frame_count),
                                 "int: number of frames of a scan.");
  sequence.def_property_readonly("alpha_p", within(&Sequence::light, &PatternLight::alpha_p),
                                 "float: amplitude of the patterns, grey levels of 255.");
  sequence.def_property_readonly("beta_p", within(&Sequence::light, &PatternLight::beta_p),
                                 "float: offset of the patterns, grey levels of 255.");
}

void bind_pattern_pictures(py::class_<Sequence>& sequence) {
  sequence.def("patterns", &patterns_of, "bits"_a = 8, R"(
      The pictures to project, frames x rows x columns.

      Args:
          bits (int): uint8 up to 8 bits, else uint16.

      Returns:
          NDArray

      Raises:
          Error: if the projector is unknown.

      Example:
          >>> slipstream.Sequence("pmp", projector=(64, 48)).patterns().shape
          (3, 48, 64)
  )");

  const auto write = [](const Sequence& self, const fs::path& folder, int bits) {
    return write_patterns(folder, pattern_set(cycle_of(self)), self, bits, [] {});
  };

  sequence.def("write_patterns", write, "folder"_a, "bits"_a = 8, Unlocked(), R"(
      Writes the pictures with a scan.yaml that describes them.

      Args:
          folder (str | PathLike): created if missing.
          bits (int): bits per pixel.

      Returns:
          list[PathLike]: their paths.

      Example:
          >>> len(slipstream.Sequence("pmp", projector=(64, 48)).write_patterns("patterns"))
          3
  )");
}

void bind_sequence(py::module_& module) {
  py::class_<Sequence> sequence(module, "Sequence", R"(
      The pattern sequence of one scan.

      Args:
          strategy (Strategy | str): coding, or its label.
          axis (Literal["x", "y", "both"]): direction of the coordinate.
          projector (tuple[int, int], default (0, 0)): width and height, pixels; (0, 0) if
              unknown.
          alpha_p (float, default 255.0): amplitude of the patterns, grey levels of 255.
          beta_p (float, default 0.0): offset of the patterns, grey levels of 255.
          marker (bool, default False): a dark frame ends each cycle.
          exposures (typing.Sequence[float], default [1.0]): relative, any unit.
          binary (bool, default False): dithered to 1 bit, for DMD projectors.
          motion (int, default 0): extra frames per cloud for motion compensation: 0, 2 or 4.

      Example:
          >>> slipstream.Sequence("pmp, steps 4", axis="both").frames
          8
  )");

  sequence.def(py::init(&sequence_from), "strategy"_a, "axis"_a = "x");
  sequence.def(py::self == py::self);

  bind_sequence_properties(sequence);
  bind_pattern_pictures(sequence);
}

}  // namespace

void bind_sequences(py::module_& module) {
  bind_strategy(module);
  bind_strategy_lists(module);
  bind_sequence(module);
}

}  // namespace slipstream::python
