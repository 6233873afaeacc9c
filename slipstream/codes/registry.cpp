#include "slipstream/codes/registry.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "slipstream/base/did_you_mean.h"
#include "slipstream/base/error.h"

namespace slipstream {
namespace {

/// Calls `visit` with every coding of the registry at its default settings.
template <class Visit>
void for_each_coding(const Visit& visit) {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (visit(std::variant_alternative_t<I, KnownCodings>{}), ...);
  }
  (std::make_index_sequence<std::variant_size_v<KnownCodings>>{});
}

template <class Coding>
std::string setting_names(const Coding& coding) {
  std::string names;
  Coding::for_each_setting(coding, [&](const char* name, const char*, const auto&) {
    names += names.empty() ? name : fmt::format(", {}", name);
  });
  return names;
}

/// Throws Error, naming the setting, where the value is none of its kind.
template <class Value>
void set(Value& target, const std::string& name, const SettingValue& value) {
  try {
    if constexpr (requires { target.has_value(); }) {
      value.read(target.emplace());
    } else {
      value.read(target);
    }
  } catch (const Error& error) {
    throw Error(fmt::format("{} {}", name, error.what()));
  }
}

template <class Coding>
Strategy configured(Coding coding, const StrategySettings& settings) {
  for (const auto& [wanted, value] : settings) {
    bool found = false;
    Coding::for_each_setting(coding, [&](const char* name, const char*, auto& target) {
      if (wanted != name) return;
      set(target, wanted, value);
      found = true;
    });
    if (!found) {
      throw Error(fmt::format("strategy {} has no setting '{}'; it has {}", Coding::name, wanted,
                              setting_names(coding)));
    }
  }
  return coding;
}

}  // namespace

Strategy default_strategy() {
  return DualFrequency{};
}

std::vector<Strategy> usual_strategies() {
  return {DualFrequency{.steps = 3, .high = 16}, DualFrequency{.steps = 4, .high = 32},
          PhaseMeasuring{.steps = 3}, PhaseMeasuring{.steps = 4}, PhaseMeasuring{.steps = 6}};
}

std::string label_of(const Strategy& strategy) {
  std::string label = strategy.name();
  for (const auto& [name, value] : strategy.settings()) {
    label += fmt::format(", {} {}", name, value.text());
  }
  return label;
}

Strategy strategy_labelled(std::string_view label) {
  StrategySettings settings;
  const std::string_view name = label.substr(0, label.find(", "));
  for (std::string_view rest = label.substr(name.size()); !rest.empty();) {
    rest.remove_prefix(2);
    const std::string_view setting = rest.substr(0, rest.find(", "));
    rest.remove_prefix(setting.size());
    const std::string_view word = setting.substr(0, setting.find(' '));
    if (word.empty() || word.size() + 1 >= setting.size()) {
      throw Error(fmt::format("'{}' in '{}' is no setting; give a name and a value, as steps 4",
                              setting, label));
    }
    settings[std::string(word)] = std::string(setting.substr(word.size() + 1));
  }
  return make_strategy(name, settings);
}

std::vector<Strategy> strategies_to_compare() {
  return {PhaseChannelMultiplexing{.steps = 3},  PhaseChannelMultiplexing{.steps = 4},
          PhaseChannelMultiplexing{.steps = 5},  PhaseMeasuring{.steps = 6},
          DualFrequency{.steps = 3, .high = 16}, DualFrequency{.steps = 4, .high = 32}};
}

std::vector<std::string_view> strategy_names() {
  std::vector<std::string_view> names;
  for_each_coding([&](const auto& coding) { names.push_back(coding.name); });
  return names;
}

std::vector<std::string_view> names_with_coordinate() {
  std::vector<std::string_view> names;
  for_each_coding([&](const auto& coding) {
    if (has_coordinate(Strategy(coding))) names.push_back(coding.name);
  });
  return names;
}

std::vector<SettingDescription> strategy_settings() {
  std::vector<SettingDescription> settings;
  for_each_coding([&]<class Coding>(const Coding& coding) {
    const StrategySettings usual = settings_from(coding);
    Coding::for_each_setting(coding, [&](const char* name, const char* help, const auto& value) {
      using Value = std::remove_cvref_t<decltype(value)>;
      constexpr bool is_switch =
          std::is_same_v<Value, bool> || std::is_same_v<Value, std::optional<bool>>;
      constexpr bool is_word = std::is_same_v<Value, std::string>;
      std::string owner(Coding::name);
      if (usual.contains(name)) owner += fmt::format(" {}", usual.at(name).text());
      const auto known = std::find_if(settings.begin(), settings.end(),
                                      [&](const auto& setting) { return setting.name == name; });
      if (known == settings.end()) {
        settings.push_back({name, help, owner, is_switch, is_word});
      } else {
        known->strategies += ", " + owner;
      }
    });
  });
  return settings;
}

Strategy make_strategy(std::string_view name, const StrategySettings& settings) {
  std::optional<Strategy> made;
  for_each_coding([&](const auto& coding) {
    if (coding.name == name) made = configured(coding, settings);
  });
  if (!made) {
    throw Error(fmt::format("strategy '{}' is not known; it is one of: {}{}", name,
                            fmt::join(strategy_names(), ", "),
                            did_you_mean(name, strategy_names())));
  }
  return *made;
}

}  // namespace slipstream
