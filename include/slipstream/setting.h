#pragma once

#include <limits>
#include <optional>
#include <type_traits>

namespace slipstream {

/// Describes one setting of a struct. The struct visits each setting with its member:
///   template <class Self, class Visit>
///   static void for_each_setting(Self& self, const Visit& visit);  // visit(Setting, self.member)
/// Validation, command line, rig file, live changes and Python keywords are all driven by it.
struct Setting {
  /// How it may change during a live run; without `help` it cannot.
  struct Live {
    const char* help = "";
    const char* unit = "";
    double least = 0, most = 0;  ///< range of a number
  };

  const char* name;  ///< member name and Python keyword; messages show it with spaces
  /// Short name by which a command line or page offers it, without dashes, e.g. "widest-gap";
  /// empty: not offered.
  const char* option = "";
  const char* help = "";  ///< of option and keyword; names other settings as messages do, see Error
  const char* unit = "";  ///< e.g. "mm"

  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();

  bool above_least = false;    ///< excludes `least` itself from the range
  bool option_clears = false;  ///< the option of a boolean sets it to false

  Live live{};
};

/// Throws Error if out of range: "widest gap -1 is out of range; 0 pixels or more".
void require_in_range(const Setting& setting, double value);

/// Checks every number of a struct of settings; optional ones only if set.
template <class Settings>
void require_in_range(const Settings& settings) {
  Settings::for_each_setting(settings, [](const Setting& setting, const auto& value) {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, std::optional<double>>) {
      if (value) require_in_range(setting, *value);
    } else if constexpr (std::is_arithmetic_v<Value> && !std::is_same_v<Value, bool>) {
      require_in_range(setting, static_cast<double>(value));
    }
  });
}

}  // namespace slipstream
