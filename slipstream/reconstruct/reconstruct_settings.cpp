#include "slipstream/reconstruct/reconstruct_settings.h"

#include <cmath>
#include <string_view>
#include <variant>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

void require_valid(const ReconstructSettings& settings) {
  const auto require = [](bool holds, std::string_view name, double value, std::string_view range) {
    if (!holds) throw Error(fmt::format("{} {} is out of range; {}", name, value, range));
  };
  const double least = settings.minimum_modulation.value_or(0);
  require(least >= 0 && std::isfinite(least), "minimum modulation", least, "0 grey levels or more");
  require(settings.field_margin >= 0, "field margin", settings.field_margin, "0 or more");
  require(settings.nearest >= 0, "nearest depth", settings.nearest, "0 mm or more");
  require(settings.farthest > settings.nearest, "farthest depth", settings.farthest,
          "more than the nearest");
  require_valid(settings.cue);
  for (const auto& [N, correction] : settings.phase_corrections) require_valid(correction, N);
}

}  // namespace

void require_reconstructible(const Scanner& scanner, const Strategy& strategy, Axis axis,
                             const ReconstructSettings& settings) {
  require_valid(scanner);
  require_depth_visible(scanner, axis);
  std::visit([](const auto& chosen) { chosen.require_valid(); }, strategy);
  require_resolved(strategy, length_along(axis, scanner.projector.size));
  if (!has_coordinate(strategy)) {
    throw Error(fmt::format(
        "{}: more than one period covers the field, so these frames alone give no depth; use "
        "frequency 1 or dual-frequency",
        name_of(strategy)));
  }
  require_valid(settings);
}

double least_modulation(const ReconstructSettings& settings, double full_scale) {
  return settings.minimum_modulation.value_or(15 * full_scale / 255);
}

double least_neighbour_modulation(const ReconstructSettings& settings, double full_scale) {
  return 0.8 * least_modulation(settings, full_scale);
}

}  // namespace slipstream
