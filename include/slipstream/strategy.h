#pragma once

#include <concepts>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "slipstream/gray_code.h"
#include "slipstream/one_frame.h"
#include "slipstream/pattern_set.h"
#include "slipstream/phase_channel_multiplexing.h"

namespace slipstream {

/// A strategy's setting as text: a number, comma-separated numbers, a word, "true" or "false".
class SettingValue {
 public:
  SettingValue() = default;
  SettingValue(std::string text) : text_(std::move(text)) {}  // NOLINT(google-explicit-constructor)
  SettingValue(const char* text) : text_(text) {}             // NOLINT(google-explicit-constructor)
  template <class Number>
  requires std::integral<Number> || std::floating_point<Number> SettingValue(
      Number number)  // NOLINT(google-explicit-constructor)
      : text_(text_of(static_cast<double>(number))) {}
  SettingValue(bool value) : text_(value ? "true" : "false") {}  // NOLINT
  SettingValue(const std::vector<double>& numbers);  // NOLINT(google-explicit-constructor)
  SettingValue(const std::vector<int>& numbers)      // NOLINT(google-explicit-constructor)
      : SettingValue(std::vector<double>(numbers.begin(), numbers.end())) {}

  [[nodiscard]] const std::string& text() const { return text_; }

  /// A single number. Throws Error if it is anything else.
  [[nodiscard]] double number() const;

  // Convert to the type of a coding's member; each throws Error if the text does not fit.
  void read(double& value) const { value = number(); }
  void read(int& value) const;
  void read(bool& value) const;
  void read(std::string& value) const { value = text_; }
  void read(std::vector<double>& values) const;
  void read(std::vector<int>& values) const;

  friend bool operator==(const SettingValue&, const SettingValue&) = default;

 private:
  static std::string text_of(double number);

  std::string text_;
};

/// Settings of a strategy, by the names that struct, scan.yaml and command line share.
using StrategySettings = std::map<std::string, SettingValue>;

/// A coding's settings from for_each_setting: see Strategy. Omits empty ones, and zero or false if
/// that is the default.
template <class Coding>
StrategySettings settings_from(const Coding& coding) {
  // Every setting that has a value.
  const auto all = [](const Coding& of) {
    StrategySettings settings;
    Coding::for_each_setting(of, [&](const char* name, const char*, const auto& value) {
      if constexpr (requires { value.has_value(); }) {
        if (value) settings[name] = *value;
      } else {
        settings[name] = value;
      }
    });
    return settings;
  };

  // Empty, zero and false ones that are the default anyway are left out.
  StrategySettings settings = all(coding);
  const StrategySettings usual = all(Coding{});
  std::erase_if(settings, [&](const auto& setting) {
    const auto& [name, value] = setting;
    const bool nothing =
        value == SettingValue(0) || value == SettingValue(false) || value == SettingValue();
    return nothing && usual.contains(name) && usual.at(name) == value;
  });

  return settings;
}

/// A strategy: name, settings, pattern shape and layout of the frames. All code that decodes,
/// predicts, calibrates or simulates reads these and never depends on the name.
///
/// It is made from a struct that declares a coding: PhaseMeasuring and others in this folder, or
/// your own. Such a struct has
///   static constexpr std::string_view name
///   static void for_each_setting(auto& self, const auto& visit)
///     which calls visit(name, help text, member) for each setting: an int, a double, a bool,
///     a string, a vector of numbers or a std::optional of one of these;
///   void require_valid() const, which throws Error for settings out of range;
///   double shape(int n, double y) const, the intensity of pattern n, in [0, 1], at the projector
///     coordinate y in [0, 1];
///   Layout layout() const;
/// or instead of the shape
///   std::vector<Sinusoid> runs() const, shown in sequence; frames of the layout's code need
///     neither;
/// or instead of both
///   std::vector<ShownSinusoid> sinusoids() const, which frames show together; fitted_bands
///     separates them, and several are unwrapped hierarchically.
/// A coding whose frames multiplex several patterns has the layout of the frames extracted from
/// them, and also
///   Demodulation demodulation() const, and
///   double read_shape(int n, double y) const, the pattern of extracted frame n.
/// A coding whose Demodulation has a grid requires neither shapes nor layout.
/// A value type; copies share no mutable state.
class Strategy {
 public:
  /// Three-step PMP of one period.
  Strategy();

  /// Throws Error if the struct's settings or its layout are invalid.
  template <class Coding>
  requires requires(const Coding& coding) { coding.require_valid(); }
  Strategy(const Coding& coding)  // NOLINT(google-explicit-constructor)
      : name_(Coding::name), settings_(settings_from(coding)) {
    coding.require_valid();

    if constexpr (requires { coding.sinusoids(); }) {
      // The frames show all sinusoids together; their weights are fitted.
      show(coding.sinusoids());
    } else if constexpr (requires { coding.layout(); }) {
      // The coding knows its own layout, of the extracted frames if they are demodulated.
      layout_ = coding.layout();
      if constexpr (requires { coding.demodulation(); }) {
        demodulation_ = coding.demodulation();
        read_shape_ = [coding](int n, double y) { return coding.read_shape(n, y); };
      }

      // Its patterns: a function of both coordinates or of one, runs of sinusoids, or a code alone.
      if constexpr (requires { coding.shape(0, 0.0, 0.0); }) {
        shape_ = [coding](int n, double y, double across) { return coding.shape(n, y, across); };
      } else if constexpr (requires { coding.shape(0, 0.0); }) {
        shape_ = [coding](int n, double y) { return coding.shape(n, y); };
      } else if constexpr (requires { coding.runs(); }) {
        show(coding.runs());
      } else {
        show(std::vector<Sinusoid>{});
      }
    } else {
      // A grid is decoded as fringes and needs only its demodulation.
      show(coding.demodulation());
    }

    require_valid(layout_, name_);
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  /// The settings that make_strategy requires to make the same strategy again.
  [[nodiscard]] const StrategySettings& settings() const { return settings_; }

  /// Layout of the decoded frames: the displayed ones, or those that demodulation extracts.
  [[nodiscard]] const Layout& layout() const { return layout_; }
  operator const Layout&() const { return layout_; }  // NOLINT(google-explicit-constructor)

  /// How displayed frames become the decoded ones; nullopt if they are the same.
  [[nodiscard]] std::optional<Demodulation> demodulation() const {
    return read_ ? std::nullopt : demodulation_;
  }
  /// The strategy whose displayed frames are the decoded ones; unchanged without demodulation.
  [[nodiscard]] Strategy read_as() const;
  /// Whether frames are, or were, separated by their spectra.
  [[nodiscard]] bool is_spectral() const { return demodulation_.has_value(); }

  /// Intensity of pattern n, in [0, 1], at projector coordinate y in [0, 1]; see PatternShape.
  [[nodiscard]] double shape(int n, double y, double across = 0) const {
    return shape_(n, y, across);
  }

  /// The same patterns, repeated: a cycle and `extra` frames, starting with pattern `first`:
  /// the steps of the window cancel the error of steady motion.
  [[nodiscard]] Strategy in_motion(int extra, int first = 0) const;

  /// Compares name, settings, layout and demodulation.
  friend bool operator==(const Strategy& a, const Strategy& b) {
    return a.name_ == b.name_ && a.settings_ == b.settings_ && a.layout_ == b.layout_ &&
           a.demodulation_ == b.demodulation_ && a.read_ == b.read_;
  }

 private:
  void show(std::vector<ShownSinusoid> sinusoids);
  void show(std::vector<Sinusoid> runs);
  void show(Demodulation grid);

  std::string name_;
  StrategySettings settings_;
  Layout layout_;
  PatternShape shape_;
  std::optional<Demodulation> demodulation_;
  PatternShape read_shape_;  ///< with a demodulation only
  bool read_ = false;        ///< whether demodulation is already done
};

/// Frames of one scan.
int frame_count(const Strategy& strategy);

/// See the same functions for a Layout.
inline bool has_coordinate(const Strategy& strategy) {
  return has_coordinate(strategy.layout());
}

double carrier_periods(const Strategy& strategy);

/// Throws Error if the projector cannot resolve it: less than two pixels a period along the axis
/// or, for a carrier, across it; less than one pixel per stripe of a code.
void require_resolved(const Strategy& strategy, Axis axis, Size projector);

/// The patterns to display.
PatternSet pattern_set(const Strategy& strategy, Axis axis, const PatternLight& light = {});

/// The registry: every coding available by name. Add new ones here.
using KnownCodings =
    std::variant<PhaseMeasuring, DualFrequency, PhaseChannelMultiplexing, MultiFrequency, GrayCode,
                 GrayPhase, ExclusiveOrGray, TwoPlusOne, FastThreeStep, DoubleThreeStep,
                 TwoFrequency2N, TwoFrequency4N, MicroPhaseShifting, ModulatedPhaseShifting,
                 PeriodCoded, FourierProfilometry, CompositePattern, DeBruijn, SymbolArray>;

inline Strategy default_strategy() {
  return DualFrequency{};
}

/// The given strategy and the most common ones, to choose from; these give a projector coordinate.
std::vector<Strategy> strategies_beside(const Strategy& given);

/// Name and settings in a line: "dual-frequency, high 16, low 1, steps 3".
std::string label_of(const Strategy& strategy);

/// Parses such a line; other settings are default. Throws like make_strategy, and for a setting
/// without a value.
Strategy strategy_labelled(std::string_view label);

/// Representative strategies of each kind and size, fewest frames first.
std::vector<Strategy> strategies_to_compare();

/// A setting for the command line.
struct SettingDescription {
  std::string name;
  std::string help;        ///< a short description
  std::string strategies;  ///< which have it, with defaults: "pmp 4, dual-frequency 3"
  bool is_switch = false;  ///< on or off
  bool is_word = false;    ///< otherwise a number, or comma-separated numbers
};

/// Names of all strategies, in the order of the registry.
std::vector<std::string_view> strategy_names();

/// Names of the strategies that give a projector coordinate with default settings.
std::vector<std::string_view> names_with_coordinate();

/// Every setting of any strategy, once.
std::vector<SettingDescription> strategy_settings();

/// The strategy called `name`; other settings are default. Throws Error for an unknown name or
/// setting, or a value out of range.
Strategy make_strategy(std::string_view name, const StrategySettings& settings);

}  // namespace slipstream
