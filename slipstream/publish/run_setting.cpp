#include "slipstream/publish/run_setting.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/did_you_mean.h"
#include "slipstream/base/error.h"
#include "slipstream/base/number_text.h"

namespace slipstream {

void require_settable(const std::vector<RunSetting>& settings, const std::string& name,
                      const std::string& value) {
  const auto setting = std::find_if(settings.begin(), settings.end(),
                                    [&](const RunSetting& known) { return known.name == name; });
  if (setting == settings.end()) {
    std::vector<std::string> names;
    std::transform(settings.begin(), settings.end(), std::back_inserter(names),
                   [](const RunSetting& known) { return known.name; });
    throw Error(fmt::format("there is no setting '{}' now{}; there are {}", name,
                            did_you_mean(name, names), fmt::join(names, ", ")));
  }
  const auto& [_, help, unit, now, choices, least, most, state] = *setting;
  if (choices.empty()) {
    const auto number = number_in<double>(value);
    if (number && *number >= least && *number <= most) return;
    throw Error(fmt::format("{} '{}': a number from {:g} to {:g}{}{} is wanted", name, value, least,
                            most, unit.empty() ? "" : " ", unit));
  }
  if (std::find(choices.begin(), choices.end(), value) != choices.end()) return;
  throw Error(fmt::format("{} '{}': wanted is one of: {}{}", name, value, fmt::join(choices, "; "),
                          did_you_mean(value, choices)));
}

}  // namespace slipstream
