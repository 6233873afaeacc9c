#include "slipstream/strategy/strategy.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream {
namespace {

/// Calls `visit` with every strategy of the registry at its default settings.
template <class Visit>
void for_each_strategy(const Visit& visit) {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (visit(std::variant_alternative_t<I, Strategy>{}), ...);
  }
  (std::make_index_sequence<std::variant_size_v<Strategy>>{});
}

template <class Alternative>
std::string setting_names(Alternative strategy) {
  std::string names;
  Alternative::for_each_setting(strategy, [&](const char* name, const char*, const auto&) {
    names += names.empty() ? name : fmt::format(", {}", name);
  });
  return names;
}

int whole_number(const std::string& name, double value) {
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
    throw Error(fmt::format("{} {} is not a whole number", name, value));
  }
  return static_cast<int>(value);
}

void set(int& target, const std::string& name, double value) {
  target = whole_number(name, value);
}
void set(std::optional<int>& target, const std::string& name, double value) {
  target = whole_number(name, value);
}
void set(double& target, const std::string&, double value) {
  target = value;
}
void set(std::optional<double>& target, const std::string&, double value) {
  target = value;
}

std::optional<double> get(int value) {
  return value;
}
std::optional<double> get(const std::optional<int>& value) {
  return value;
}
std::optional<double> get(double value) {
  return value;
}
std::optional<double> get(const std::optional<double>& value) {
  return value;
}

template <class Alternative>
Alternative configured(Alternative strategy, const StrategySettings& settings) {
  for (const auto& [wanted, value] : settings) {
    bool found = false;
    Alternative::for_each_setting(strategy, [&](const char* name, const char*, auto& target) {
      if (wanted != name) return;
      set(target, wanted, value);
      found = true;
    });
    if (!found) {
      throw Error(fmt::format("strategy {} has no setting '{}'; it has {}", Alternative::name,
                              wanted, setting_names(strategy)));
    }
  }
  strategy.require_valid();
  return strategy;
}

}  // namespace

std::vector<std::string_view> strategy_names() {
  std::vector<std::string_view> names;
  for_each_strategy([&](const auto& strategy) { names.push_back(strategy.name); });
  return names;
}

std::vector<SettingDescription> strategy_settings() {
  std::vector<SettingDescription> settings;
  for_each_strategy([&]<class Alternative>(Alternative strategy) {
    const std::string owner(Alternative::name);
    Alternative::for_each_setting(strategy, [&](const char* name, const char* help, const auto&) {
      const auto known = std::find_if(settings.begin(), settings.end(),
                                      [&](const auto& setting) { return setting.name == name; });
      if (known == settings.end()) {
        settings.push_back({name, help, owner});
      } else {
        known->strategies += ", " + owner;
      }
    });
  });
  return settings;
}

Strategy make_strategy(std::string_view name, const StrategySettings& settings) {
  std::optional<Strategy> made;
  for_each_strategy([&](const auto& strategy) {
    if (strategy.name == name) made = configured(strategy, settings);
  });
  if (!made) {
    throw Error(fmt::format("strategy '{}' is not known; it is one of: {}", name,
                            fmt::join(strategy_names(), ", ")));
  }
  return *made;
}

std::string_view name_of(const Strategy& strategy) {
  return std::visit([](const auto& chosen) { return chosen.name; }, strategy);
}

StrategySettings settings_of(const Strategy& strategy) {
  StrategySettings settings;
  std::visit(
      [&]<class Chosen>(const Chosen& chosen) {
        Chosen::for_each_setting(chosen, [&](const char* name, const char*, const auto& value) {
          if (const std::optional<double> number = get(value)) settings[name] = *number;
        });
      },
      strategy);
  return settings;
}

int frame_count(const Strategy& strategy) {
  return std::visit([](const auto& chosen) { return chosen.frame_count(); }, strategy);
}

std::vector<int> step_counts(const Strategy& strategy) {
  return std::visit([](const auto& chosen) { return chosen.step_counts(); }, strategy);
}

bool has_coordinate(const Strategy& strategy) {
  return std::visit([](const auto& chosen) { return chosen.has_coordinate(); }, strategy);
}

double highest_frequency(const Strategy& strategy) {
  return std::visit([](const auto& chosen) { return chosen.highest_frequency(); }, strategy);
}

void require_resolved(const Strategy& strategy, int length) {
  const double highest = highest_frequency(strategy);
  if (2 * highest > length) {
    throw Error(fmt::format(
        "frequency {} is too high for {} projector pixels; at most {} periods can be shown",
        highest, length, length / 2));
  }
}

double coordinate_variance(const Strategy& strategy, double modulation, double noise_variance) {
  return std::visit(
      [&](const auto& chosen) {
        // Alpha and alpha_p bear on the noise by their product alone.
        constexpr double alpha_p = 2;
        return chosen.coordinate_variance(modulation / chosen.modulation_share(), alpha_p,
                                          noise_variance);
      },
      strategy);
}

PatternSet pattern_set(const Strategy& strategy, Axis axis, const PatternLight& light) {
  std::visit([](const auto& chosen) { chosen.require_valid(); }, strategy);
  require_valid(light);
  return {.count = frame_count(strategy),
          .axis = axis,
          .light = light,
          .shape = [strategy](int n, double y) {
            return std::visit([&](const auto& chosen) { return chosen.shape(n, y); }, strategy);
          }};
}

}  // namespace slipstream
