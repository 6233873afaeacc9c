#pragma once

#include <string>
#include <string_view>

namespace slipstream {

/// The text with its control characters and line breaks as "\x1b": ASCII, and U+0080 to U+009F.
/// Names and contents of files may hold some, which a terminal would obey.
std::string printable(std::string_view text);

/// The same, but line breaks stay: for texts of several lines.
std::string printable_lines(std::string_view text);

}  // namespace slipstream
