#pragma once

#include <string>
#include <string_view>

namespace slipstream::app {

/// The flag of a setting with the same name: "--low-steps" of "low_steps".
std::string flag_of(std::string_view name);

/// The flag with its name of earlier versions, as CLI11 separates them: "--widest-gap,--fill".
std::string with_former_name(const std::string& flag);

/// Whether earlier versions called a flag so, without dashes. It is read and not shown.
bool is_former_name(std::string_view name);

/// The present name of a setting: "widest-gap" also of "fill".
std::string present_name(std::string_view name);

/// A text of the library in the program's words: settings and operations in backquotes become flags
/// and commands, see Error. "`low_steps`" becomes "--low-steps", "`order 2,0,1`" "--order 2,0,1",
/// "`excluded`" "--exclude", and "`calibrate_gamma()`" "slipstream calibrate gamma". Leaves all
/// other text as it is, also commands in backquotes: "`project
/// --list`".
std::string with_flags(std::string_view text);

}  // namespace slipstream::app
