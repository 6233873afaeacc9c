#pragma once

#include <string>
#include <string_view>

namespace slipstream::app {

/// The flag of a setting with the same name: "--low-steps" of "low_steps".
std::string flag_of(std::string_view name);

/// A text of the library in the program's words: settings and operations in backquotes become flags
/// and commands, see Error. "`low_steps`" becomes "--low-steps", "`order 2,0,1`" "--order 2,0,1",
/// "`widest_gap`" "--fill", as its description says, and "`calibrate_gamma()`" "slipstream
/// calibrate gamma". Leaves all other text as it is, also commands in backquotes: "`project
/// --list`".
std::string with_flags(std::string_view text);

}  // namespace slipstream::app
