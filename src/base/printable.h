#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace slipstream {

/// The text with its control characters and line breaks as "\x1b": ASCII, and U+0080 to U+009F.
/// Names and contents of files may hold some, which a terminal would obey.
std::string printable(std::string_view text);

/// The same, but line breaks stay: for texts of several lines.
std::string printable_lines(std::string_view text);

/// "1 cloud", "3 clouds".
std::string counted(std::size_t count, std::string_view noun);

/// A text of the library, see Error, with what `named` gives for each text between backquotes, in
/// place of these too; where it gives nullopt, they stay.
std::string with_names(std::string_view text,
                       std::optional<std::string> (*named)(std::string_view quoted));

}  // namespace slipstream
