#pragma once

#include <string>
#include <vector>

namespace slipstream {

/// Something of a run that can be changed while it goes on, as it is now.
struct RunSetting {
  std::string name;                    ///< as the flag of `slipstream live`: "min-modulation"
  std::string help;                    ///< what it means, in a few words
  std::string unit{};                  ///< of a number: "ms"; empty where it has none
  std::string value{};                 ///< a number, or one of the choices
  std::vector<std::string> choices{};  ///< "off" and "on" of a switch; empty for a number
  double least = 0, most = 0;          ///< of a number
  std::string state{};                 ///< what is to be said beside it; mostly empty
};

/// Throws Error, one line with what would be right, where there is no setting of that name or it
/// cannot have that value.
void require_settable(const std::vector<RunSetting>& settings, const std::string& name,
                      const std::string& value);

}  // namespace slipstream
