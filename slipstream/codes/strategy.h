#pragma once

#include <concepts>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "slipstream/codes/demodulation.h"
#include "slipstream/codes/layout.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {

/// What a setting of a strategy is set to, as files and command lines have it: a number, numbers
/// with commas between, a word, or "true" and "false".
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
  void read(double& value) const;
  void read(int& value) const;
  void read(bool& value) const;
  void read(std::string& value) const;
  void read(std::vector<double>& values) const;
  void read(std::vector<int>& values) const;

  friend bool operator==(const SettingValue&, const SettingValue&) = default;

 private:
  static std::string text_of(double number);

  std::string text_;
};

/// Settings of a strategy by the names that struct, scan.yaml and command line share.
using StrategySettings = std::map<std::string, SettingValue>;

/// What a coding's struct holds, by for_each_setting: see Strategy. What is empty, and what is 0 or
/// false as in a struct that nobody has set, is left out.
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
///   template <class Self, class Visit> static void for_each_setting(Self& self, const Visit&
///   visit)
///     which calls visit(name, words of help, member) for each setting: an int, a double, a bool,
///     a string, a vector of numbers or a std::optional of one of these;
///   void require_valid() const, which throws Error for settings outside their ranges;
///   double shape(int n, double y) const, the intensity of pattern n, in [0, 1], at the projector
///     coordinate y in [0, 1];
///   Layout layout() const;
/// or instead of the last two
///   std::vector<ShownSinusoid> sinusoids() const, which frames show together and phases are taken
///     from by fitted_bands, unwrapped hierarchically where there are several.
/// One whose frames hold several things at once has a layout of the frames that are taken out of
/// them, and beside it
///   Demodulation demodulation() const, and
///   double read_shape(int n, double y) const, what would show frame n of those.
/// One whose Demodulation has a grid needs no shapes.
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
    } else {
      layout_ = coding.layout();
      if constexpr (requires { coding.demodulation(); }) {
        demodulation_ = coding.demodulation();
        if constexpr (requires { coding.read_shape(0, 0.0); }) {
          read_shape_ = [coding](int n, double y) { return coding.read_shape(n, y); };
        } else {
          show_grid();
        }
      }
      if constexpr (requires { coding.shape(0, 0.0, 0.0); }) {
        shape_ = [coding](int n, double y, double across) { return coding.shape(n, y, across); };
      } else if constexpr (requires { coding.shape(0, 0.0); }) {
        shape_ = [coding](int n, double y) { return coding.shape(n, y); };
      }
    }
    require_valid(layout_, name_);
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Those that make_strategy needs to give the same strategy again.
  [[nodiscard]] const StrategySettings& settings() const { return settings_; }
  /// Of the frames that are read: those shown, or those that demodulation makes of them.
  [[nodiscard]] const Layout& layout() const { return layout_; }
  /// How frames that are shown become those that are read; none where they are the same.
  [[nodiscard]] std::optional<Demodulation> demodulation() const;
  /// What would show the frames that are read; the same where these are what is shown.
  [[nodiscard]] Strategy read_as() const;
  /// Whether it is, or is read as, one whose frames are taken apart by their spectra.
  [[nodiscard]] bool is_spectral() const { return demodulation_.has_value(); }
  /// Intensity of pattern n, in [0, 1], at projector coordinate y in [0, 1]; see PatternShape.
  [[nodiscard]] double shape(int n, double y, double across = 0) const {
    return shape_(n, y, across);
  }

  /// The same patterns shown over and over, and so many more frames of them than a cycle, from
  /// pattern `first` on: see motion_window.
  [[nodiscard]] Strategy in_motion(int extra, int first = 0) const;

  /// Of name, settings, layout and demodulation.
  friend bool operator==(const Strategy& a, const Strategy& b) {
    return a.name_ == b.name_ && a.settings_ == b.settings_ && a.layout_ == b.layout_ &&
           a.demodulation_ == b.demodulation_ && a.read_ == b.read_;
  }

 private:
  void show(std::vector<ShownSinusoid> sinusoids);
  void show_grid();

  std::string name_;
  StrategySettings settings_;
  Layout layout_;
  PatternShape shape_;
  std::optional<Demodulation> demodulation_;
  PatternShape read_shape_;  ///< where there is a demodulation
  bool read_ = false;        ///< whether that is done
};

std::string_view name_of(const Strategy& strategy);

/// Frames of one scan.
int frame_count(const Strategy& strategy);
/// See the functions of the same names of a Layout.
std::vector<int> step_counts(const Strategy& strategy);
bool has_coordinate(const Strategy& strategy);
double highest_frequency(const Strategy& strategy);
double carrier_periods(const Strategy& strategy);

/// Throws Error when the highest frequency has less than two of the projector's pixels along the
/// axis for each period, a carrier less than two across it, or a code less than one for each
/// stripe, so that no projector of that size can show it.
void require_resolved(const Strategy& strategy, Axis axis, Size projector);

/// What the projector shows.
PatternSet pattern_set(const Strategy& strategy, Axis axis, const PatternLight& light = {});

}  // namespace slipstream
