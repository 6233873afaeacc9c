#include "python/bindings/keywords.h"

#include <array>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/did_you_mean.h"
#include "slipstream/unwrap/cue_settings.h"

namespace slipstream::python {
namespace {

using Corner = std::array<double, 3>;

void take_clean(Keywords& keywords, CleanSettings& clean) {
  keywords.take("largest_sigma", clean.largest_sigma);
  keywords.take("drop_mixed", clean.drop_mixed);
  keywords.take("drop_outliers", clean.drop_outliers);
  keywords.take("smallest_component", clean.smallest_component);
  keywords.take("widest_gap", clean.widest_gap);
  keywords.take("smoothing", clean.smoothing);
  std::optional<std::pair<Corner, Corner>> box;
  keywords.take("box", box);
  if (box) clean.box = PointBox{box->first, box->second};
  std::vector<std::pair<double, double>> outline;
  keywords.take("outline", outline);
  for (const auto& [column, row] : outline) clean.outline.push_back({column, row});
}

}  // namespace

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

CleanSettings clean_settings(const py::kwargs& given) {
  Keywords keywords(given);
  CleanSettings clean;
  take_clean(keywords, clean);
  keywords.require_none_left();
  return clean;
}

void take(Keywords& keywords, ReconstructSettings& settings) {
  std::string backend = "fused", cue_rule(name_of(settings.cue_rule));
  bool raw = false;
  keywords.take("backend", backend);
  keywords.take("minimum_modulation", settings.minimum_modulation);
  keywords.take("drop_saturated", settings.drop_saturated);
  keywords.take("largest_doubt", settings.fringe_order.largest_doubt);
  keywords.take("fewest_neighbours", settings.fringe_order.fewest_neighbours);
  keywords.take("fewest_if_doubtful", settings.fringe_order.fewest_if_doubtful);
  keywords.take("cue_rule", cue_rule);
  keywords.take("least_voting_share", settings.least_voting_share);
  keywords.take("field_margin", settings.field_margin);
  keywords.take("nearest", settings.nearest);
  keywords.take("farthest", settings.farthest);
  keywords.take("raw", raw);
  if (raw) {
    settings.clean = CleanSettings::none();
    settings.nearest = settings.nearest.value_or(0);
    settings.farthest = settings.farthest.value_or(std::numeric_limits<double>::infinity());
  }
  take_clean(keywords, settings.clean);
  set_backend(settings, backend);
  settings.cue_rule = cue_rule_named(cue_rule);
}

ReconstructSettings reconstruct_settings(const py::kwargs& given) {
  Keywords keywords(given);
  ReconstructSettings settings;
  take(keywords, settings);
  keywords.require_none_left();
  return settings;
}

}  // namespace slipstream::python
