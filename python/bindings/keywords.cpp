#include "python/bindings/keywords.h"

#include <limits>

#include <fmt/format.h>

#include "slipstream/base/did_you_mean.h"
#include "slipstream/decode/cue_settings.h"

namespace slipstream::python {

void Keywords::require_none_left() const {
  for (const auto& [name, value] : left_) {
    const auto word = name.cast<std::string>();
    throw py::type_error(
        fmt::format("there is no setting '{}'{}", word, did_you_mean(word, known_)));
  }
}

void Keywords::refuse(const char* name, const py::object& given) {
  throw py::type_error(fmt::format("{} cannot be {}", name, py::repr(given).cast<std::string>()));
}

void take(Keywords& keywords, CleanSettings& clean) {
  using Corner = std::array<double, 3>;
  std::optional<std::pair<Corner, Corner>> box;
  std::vector<std::pair<double, double>> outline;
  keywords.take("largest_sigma", clean.largest_sigma, "drop_mixed", clean.drop_mixed,
                "drop_outliers", clean.drop_outliers, "smallest_component",
                clean.smallest_component, "widest_gap", clean.widest_gap, "smoothing",
                clean.smoothing, "box", box, "outline", outline);
  if (box) clean.box = PointBox{box->first, box->second};
  for (const auto& [column, row] : outline) clean.outline.push_back({column, row});
}

void take(Keywords& keywords, ReconstructSettings& settings) {
  std::string backend = "fused", cue_rule(name_of(settings.cue_rule));
  bool raw = false;
  keywords.take(
      "backend", backend, "minimum_modulation", settings.minimum_modulation, "drop_saturated",
      settings.drop_saturated, "largest_doubt", settings.fringe_order.largest_doubt,
      "fewest_neighbours", settings.fringe_order.fewest_neighbours, "fewest_if_doubtful",
      settings.fringe_order.fewest_if_doubtful, "cue_rule", cue_rule, "least_voting_share",
      settings.least_voting_share, "field_margin", settings.field_margin, "nearest",
      settings.nearest, "farthest", settings.farthest, "raw", raw);
  if (raw) {
    settings.clean = CleanSettings::none();
    settings.nearest = settings.nearest.value_or(0);
    settings.farthest = settings.farthest.value_or(std::numeric_limits<double>::infinity());
  }
  take(keywords, settings.clean);
  set_backend(settings, backend);
  settings.cue_rule = cue_rule_named(cue_rule);
}

}  // namespace slipstream::python
