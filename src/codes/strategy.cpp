#include "slipstream/strategy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "codes/motion_window.h"

namespace slipstream {
namespace {

int whole(double number) {
  throw_if(number != std::floor(number) || std::abs(number) > std::numeric_limits<int>::max(),
           "{} is not a whole number", number);
  return static_cast<int>(number);
}

/// Calls `visit` with every registered coding at its default settings.
template <class Visit>
void for_each_coding(const Visit& visit) {
  // One call for each alternative of the variant.
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

/// Throws Error with the setting's name if the value has the wrong type.
template <class Value>
void set(Value& target, const std::string& name, const SettingValue& value) try {
  if constexpr (requires { target.has_value(); }) {
    value.read(target.emplace());
  } else {
    value.read(target);
  }
} catch (const Error& error) {
  throw Error(fmt::format("{} {}", name, error.what()));
}

template <class Coding>
bool has_setting(const Coding& coding, std::string_view wanted) {
  bool found = false;
  Coding::for_each_setting(coding, [&](const char* name, const char*, const auto&) {
    if (wanted == name) found = true;
  });

  return found;
}

template <class Coding>
Strategy configured(Coding coding, const StrategySettings& settings) {
  for (const auto& [wanted, value] : settings) {
    Coding::for_each_setting(coding, [&](const char* name, const char*, auto& target) {
      if (wanted == name) set(target, wanted, value);
    });
  }

  // Some settings exist only without shifts: see visit_steps. So all are set before.
  for (const auto& [wanted, value] : settings) {
    throw_if(!has_setting(coding, wanted), "strategy {}{} has no setting '{}'; it has {}",
             Coding::name, settings.contains("shifts") && wanted != "shifts" ? " with shifts" : "",
             wanted, setting_names(coding));
  }

  return coding;
}

}  // namespace

SettingValue::SettingValue(const std::vector<double>& numbers)
    : text_(fmt::format("{}", fmt::join(numbers, ","))) {}

std::string SettingValue::text_of(double number) {
  return fmt::format("{}", number);
}

void SettingValue::read(std::vector<double>& values) const {
  values = numbers_in<double>(text_, ',');
  const bool finite =
      std::ranges::all_of(values, [](double number) { return std::isfinite(number); });
  throw_if(values.empty() || !finite, "'{}' is not a number or comma-separated numbers", text_);
}

void SettingValue::read(std::vector<int>& values) const {
  std::vector<double> numbers;
  read(numbers);
  values.clear();
  for (const double number : numbers) values.push_back(whole(number));
}

double SettingValue::number() const {
  std::vector<double> numbers;
  read(numbers);
  throw_if(numbers.size() != 1, "'{}' is not a single number", text_);
  return numbers.front();
}

void SettingValue::read(int& value) const {
  value = whole(number());
}

void SettingValue::read(bool& value) const {
  value = text_ == "true" || text_ == "1";
  throw_if(!value && text_ != "false" && text_ != "0", "'{}' is neither true nor false", text_);
}

Strategy::Strategy() : Strategy(PhaseMeasuring{}) {}

void Strategy::show(std::vector<ShownSinusoid> sinusoids) {
  layout_ = {.frames = static_cast<int>(sinusoids.front().angle.size()),
             .bands = fitted_bands(sinusoids, name_),
             .unwrapping = sinusoids.size() > 1 ? Unwrapping::hierarchical : Unwrapping::none};

  shape_ = [sinusoids = std::move(sinusoids)](int n, double y, double across) {
    return composite_intensity(sinusoids, n, y, across);
  };
}

void Strategy::show(std::vector<Sinusoid> runs) {
  if (runs.empty() && !layout_.code) return;
  // The code's frames, if any, follow the sinusoids'.
  shape_ = [runs = std::move(runs), code = layout_.code](int n, double y) {
    const bool in_runs = !code || n < std::ranges::min(code->frames);
    return in_runs ? intensity_of(runs, n, y) : code_intensity(*code, n, y);
  };
}

void Strategy::show(Demodulation grid) {
  layout_ = fringes_of(grid);

  shape_ = [grid = grid.grid](int n, double y, double across) {
    return grid_intensity(grid, n, y, across);
  };
  // The extracted frames are sine, cosine and mean of each frequency in turn.
  read_shape_ = [frames = grid.frames](int n, double y) {
    return sine_cosine_mean_shape(n % 3, frames[n].periods, y);
  };

  demodulation_ = std::move(grid);
}

Strategy Strategy::read_as() const {
  Strategy read = *this;
  if (demodulation_) {
    read.shape_ = read_shape_;
    read.read_ = true;
  }

  return read;
}

Strategy Strategy::in_motion(int extra, int first) const {
  Strategy window = *this;
  window.layout_ = motion_window(layout_, extra, first);
  window.shape_ = [shape = shape_, first, N = layout_.frames](int n, double y, double across) {
    return shape((n + first) % N, y, across);
  };

  return window;
}

int frame_count(const Strategy& strategy) {
  const auto demodulation = strategy.demodulation();
  return demodulation ? demodulation->shown : strategy.layout().frames;
}

double carrier_periods(const Strategy& strategy) {
  double most = carrier_periods(strategy.layout());

  const auto demodulation = strategy.demodulation();
  if (!demodulation) return most;
  // Each row of symbols counts as a period across the axis.
  if (demodulation->grid.rows() > 1) most = std::max<double>(most, demodulation->grid.rows());

  for (const SpectralFrame& frame : demodulation->frames) {
    if (frame.across) most = std::max(most, frame.periods);
  }

  return most;
}

void require_resolved(const Strategy& strategy, Axis axis, Size projector) {
  const int projector_length = length_along(axis, projector);

  // A stripe of a code needs a pixel, a period two of them.
  const auto& code = strategy.layout().code;
  if (code && code->stripes > projector_length) {
    throw Error(fmt::format("{}: {} stripes are too narrow for {} projector pixels; at most {}",
                            strategy.name(), code->stripes, projector_length, projector_length));
  }

  const auto require_shown = [](const char* what, double periods, int length) {
    throw_if(2 * periods > length,
             "{} {} is too high for {} projector pixels; at most {} periods can be shown", what,
             periods, length, length / 2);
  };

  require_shown("frequency", highest_frequency(strategy), projector_length);
  require_shown("carrier", carrier_periods(strategy), length_along(across(axis), projector));
}

PatternSet pattern_set(const Strategy& strategy, Axis axis, const PatternLight& light) {
  require_valid(light);
  return {
      .count = frame_count(strategy),
      .axis = axis,
      .light = light,
      .shape = [strategy](int n, double y, double across) { return strategy.shape(n, y, across); },
      .carrier = carrier_periods(strategy) > 0};
}

std::vector<Strategy> strategies_beside(const Strategy& given) {
  std::vector<Strategy> all{given,
                            DualFrequency{.steps = 3, .high = 16},
                            DualFrequency{.steps = 4, .high = 32},
                            PhaseMeasuring{.steps = 3},
                            PhaseMeasuring{.steps = 4},
                            PhaseMeasuring{.steps = 6}};
  // The given one may be among the others.
  all.erase(std::remove(all.begin() + 1, all.end(), given), all.end());
  return all;
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

  // Each setting follows a separator, ", ".
  for (std::string_view rest = label.substr(name.size()); !rest.empty();) {
    rest.remove_prefix(2);
    const std::string_view setting = rest.substr(0, rest.find(", "));
    rest.remove_prefix(setting.size());

    // A name, a space and a value.
    const std::string_view word = setting.substr(0, setting.find(' '));
    throw_if(word.empty() || word.size() + 1 >= setting.size(),
             "'{}' in '{}' is not a setting; expected a name and a value, e.g. steps 4", setting,
             label);

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

      // Who has it, and the default there: "pmp 4".
      std::string owner(Coding::name);
      if (usual.contains(name)) owner += fmt::format(" {}", usual.at(name).text());

      // A setting that several strategies share is listed once.
      const auto known = std::ranges::find(settings, name, &SettingDescription::name);
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

  throw_if(!made, "strategy '{}' is unknown; expected one of: {}{}", name,
           fmt::join(strategy_names(), ", "), did_you_mean(name, strategy_names()));
  return *made;
}

}  // namespace slipstream
