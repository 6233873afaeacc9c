#pragma once

#include <concepts>
#include <map>
#include <string>
#include <utility>
#include <vector>

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

}  // namespace slipstream
