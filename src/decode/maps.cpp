#include "slipstream/maps.h"

#include <array>
#include <cstddef>

#include "base/names.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

constexpr std::array<std::string_view, 4> method_names{"equation", "closed-form", "lut",
                                                       "intensity-ratio"};

constexpr std::array<std::string_view, 3> rule_names{"published", "likelihood", "consensus"};

}  // namespace

std::string_view name_of(PhaseMethod method) {
  return method_names[static_cast<std::size_t>(method)];
}

std::string_view name_of(CueRule rule) {
  return rule_names[static_cast<std::size_t>(rule)];
}

CueRule cue_rule_named(std::string_view name) {
  const auto rule = value_named<CueRule>(name, rule_names);
  throw_if(!rule, "unwrapping '{}' is unknown; expected published, likelihood or consensus", name);
  return *rule;
}

}  // namespace slipstream
