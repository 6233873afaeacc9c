#pragma once

#include <limits>
#include <optional>
#include <type_traits>

namespace slipstream {

/// One setting of a struct, described beside the struct, which visits each with its member:
///   template <class Self, class Visit>
///   static void for_each_setting(Self& self, const Visit& visit);  // visit(Setting, self.member)
/// Validation, command line, rig file, changes of a live run and Python's keywords use this line.
struct Setting {
  /// How it may change during a live run; not at all without `help`.
  struct Live {
    const char* help = "";
    const char* unit = "";
    double least = 0, most = 0;  ///< of a number
  };

  const char* name;       ///< the member's, and Python's keyword; in messages with spaces
  const char* unit = "";  ///< "mm"
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above_least = false;  ///< `least` itself is out of range
  const char* flag = "";     ///< on the command line: "--fill"; empty: none
  const char* help = "";     ///< of the flag
  bool flag_clears = false;  ///< the flag of a switch sets it to false
  Live live{};
};

/// Throws Error: "widest gap -1 is out of range; 0 pixels or more".
void require_in_range(const Setting& setting, double value);

/// The same for every number of a struct of settings; optional ones only if they are set.
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
