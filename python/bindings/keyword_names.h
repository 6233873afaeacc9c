#pragma once

#include <string>
#include <string_view>

namespace slipstream::python {

/// A text of the library, see Error, with the module's names in backquotes: "`camera_bits 12`"
/// becomes "`bits 12`". Names of settings that only the program has become its commands:
/// "`slipstream view`".
std::string with_keywords(std::string_view text);

}  // namespace slipstream::python
