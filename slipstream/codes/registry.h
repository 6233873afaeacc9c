#pragma once

#include <map>
#include <variant>

#include "slipstream/codes/one_frame.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/phase_channel_multiplexing.h"

namespace slipstream {

/// A strategy's setting as text: a number, numbers with commas between, a word, or "true" and
/// "false".
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
  /// Of a single one. Throws Error where it is none.
  [[nodiscard]] double number() const;

  // As what a coding's struct holds; each throws Error where the text is no such thing.
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

/// Settings of a strategy by the names that struct, scan.yaml and command line share.
using StrategySettings = std::map<std::string, SettingValue>;

/// A coding's settings by for_each_setting: see Strategy. Leaves out what is empty, and zero or
/// false by default.
template <class Coding>
StrategySettings settings_from(const Coding& coding) {
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

/// What is shown to measure, and what the frames then hold: a name, settings, a shape and a layout.
/// All that decodes, predicts, calibrates or simulates reads these and asks for no name.
///
/// It is made of a struct that declares a coding: PhaseMeasuring and its neighbours in this folder,
/// or one of your own. Such a struct has
///   static constexpr std::string_view name
///   static void for_each_setting(auto& self, const auto& visit)
///     which calls visit(name, words of help, member) for each setting: an int, a double, a bool,
///     a string, a vector of numbers or a std::optional of one of these;
///   void require_valid() const, which throws Error for settings outside their ranges;
///   double shape(int n, double y) const, the intensity of pattern n, in [0, 1], at the projector
///     coordinate y in [0, 1];
///   Layout layout() const;
/// or instead of the shape
///   std::vector<Sinusoid> runs() const, shown one after the other; frames of the layout's code
///     need neither;
/// or instead of both
///   std::vector<ShownSinusoid> sinusoids() const, which frames show together and phases are taken
///     from by fitted_bands, unwrapped hierarchically where there are several.
/// One whose frames hold several things at once has a layout of the frames that are taken out of
/// them, and beside it
///   Demodulation demodulation() const, and
///   double read_shape(int n, double y) const, what would show frame n of those.
/// One whose Demodulation has a grid needs neither shapes nor layout.
/// A value; copies share nothing that changes.
class Strategy {
 public:
  /// PMP of three steps and one period.
  Strategy();
  /// Throws Error where the struct's settings or its layout are not valid.
  template <class Coding>
  requires requires(const Coding& coding) { coding.require_valid(); }
  Strategy(const Coding& coding)  // NOLINT(google-explicit-constructor)
      : name_(Coding::name), settings_(settings_from(coding)) {
    coding.require_valid();
    if constexpr (requires { coding.sinusoids(); }) {
      show(coding.sinusoids());
    } else if constexpr (requires { coding.layout(); }) {
      layout_ = coding.layout();
      if constexpr (requires { coding.demodulation(); }) {
        demodulation_ = coding.demodulation();
        read_shape_ = [coding](int n, double y) { return coding.read_shape(n, y); };
      }
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
      show(coding.demodulation());
    }
    require_valid(layout_, name_);
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Those that make_strategy needs to give the same strategy again.
  [[nodiscard]] const StrategySettings& settings() const { return settings_; }
  /// Of the frames that are read: those shown, or those that demodulation makes of them.
  [[nodiscard]] const Layout& layout() const { return layout_; }
  operator const Layout&() const { return layout_; }  // NOLINT(google-explicit-constructor)
  /// How frames that are shown become those that are read; none where they are the same.
  [[nodiscard]] std::optional<Demodulation> demodulation() const {
    return read_ ? std::nullopt : demodulation_;
  }
  /// What would show the frames that are read; the same where these are what is shown.
  [[nodiscard]] Strategy read_as() const;
  /// Whether it is, or is read as, one whose frames are taken apart by their spectra.
  [[nodiscard]] bool is_spectral() const { return demodulation_.has_value(); }
  /// Intensity of pattern n, in [0, 1], at projector coordinate y in [0, 1]; see PatternShape.
  [[nodiscard]] double shape(int n, double y, double across = 0) const {
    return shape_(n, y, across);
  }

  /// The same patterns, shown over and over, `extra` frames more than a cycle from `first` on: see
  /// motion_window.
  [[nodiscard]] Strategy in_motion(int extra, int first = 0) const;

  /// Of name, settings, layout and demodulation.
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
  PatternShape read_shape_;  ///< where there is a demodulation
  bool read_ = false;        ///< whether that is done
};

/// Frames of one scan.
int frame_count(const Strategy& strategy);
/// See the functions of the same names of a Layout.
inline bool has_coordinate(const Strategy& strategy) {
  return has_coordinate(strategy.layout());
}
double carrier_periods(const Strategy& strategy);

/// Throws Error if that projector cannot show it: less than two pixels a period along the axis or,
/// of a carrier, across it; less than one a stripe of a code.
void require_resolved(const Strategy& strategy, Axis axis, Size projector);

/// What the projector shows.
PatternSet pattern_set(const Strategy& strategy, Axis axis, const PatternLight& light = {});

/// The registry: every coding that can be asked for by its name. A new one is added here.
using KnownCodings =
    std::variant<PhaseMeasuring, DualFrequency, PhaseChannelMultiplexing, MultiFrequency, GrayCode,
                 GrayPhase, ExclusiveOrGray, TwoPlusOne, FastThreeStep, DoubleThreeStep,
                 TwoFrequency2N, TwoFrequency4N, MicroPhaseShifting, ModulatedPhaseShifting,
                 PeriodCoded, FourierProfilometry, CompositePattern, DeBruijn, SymbolArray>;

/// What is shown where nobody says what.
inline Strategy default_strategy() {
  return DualFrequency{};
}

/// What people show most, for a choice; all of it gives a projector coordinate.
std::vector<Strategy> usual_strategies();

/// Name and settings in a line: "dual-frequency, high 16, low 1, steps 3".
std::string label_of(const Strategy& strategy);

/// The strategy of such a line; other settings are default. Throws as make_strategy, and for a
/// setting without a value.
Strategy strategy_labelled(std::string_view label);

/// One of each kind and size that is worth knowing apart, of the fewest frames first.
std::vector<Strategy> strategies_to_compare();

/// A setting as the command line offers it.
struct SettingDescription {
  std::string name;
  std::string help;        ///< what it means, in a few words
  std::string strategies;  ///< which have it, with its default: "pmp 4, dual-frequency 3"
  bool is_switch = false;  ///< on or off
  bool is_word = false;    ///< else a number, or numbers with commas between
};

/// Names of all strategies, in the order of the registry.
std::vector<std::string_view> strategy_names();

/// Names of those that give a projector coordinate with their default settings.
std::vector<std::string_view> names_with_coordinate();

/// Every setting that some strategy has, once.
std::vector<SettingDescription> strategy_settings();

/// The strategy of that name; other settings are default. Throws Error for an unknown name or
/// setting, or a value out of range.
Strategy make_strategy(std::string_view name, const StrategySettings& settings);

}  // namespace slipstream
