#include "slipstream/decode/cue_settings.h"

#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

constexpr std::array<std::pair<CueRule, std::string_view>, 3> rule_names{{
    {CueRule::published, "published"},
    {CueRule::likelihood, "likelihood"},
    {CueRule::consensus, "consensus"},
}};

}  // namespace

std::string_view name_of(CueRule rule) {
  for (const auto& [value, name] : rule_names) {
    if (value == rule) return name;
  }
  return "";
}

CueRule cue_rule_named(std::string_view name) {
  for (const auto& [rule, known] : rule_names) {
    if (known == name) return rule;
  }
  throw Error(
      fmt::format("unwrapping '{}' is not known; it is published, likelihood or consensus", name));
}

void require_valid(const CueSettings& settings) {
  require_valid(settings.light);
  if (!(std::abs(settings.ambient) <= 255)) {
    throw Error(
        fmt::format("ambient light {} is out of range; -255 to 255 grey levels", settings.ambient));
  }
  if (!(settings.noise_variance > 0 && std::isfinite(settings.noise_variance))) {
    throw Error(fmt::format("noise variance {} is out of range; above 0", settings.noise_variance));
  }
  if (!(settings.least_modulation >= 0)) {
    throw Error(fmt::format("least modulation {} is out of range; 0 grey levels or more",
                            settings.least_modulation));
  }
}

}  // namespace slipstream
