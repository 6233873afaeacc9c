#include "base/printable.h"

#include <algorithm>
#include <cstddef>

#include <fmt/format.h>

namespace slipstream {
namespace {

std::string without_controls(std::string_view text, bool keeps_line_breaks) {
  std::string shown;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };

    // U+0080 to U+009F are two bytes in UTF-8: 0xc2 and the code point itself.
    const bool in_two = byte(i) == 0xc2 && i + 1 < text.size() && byte(i + 1) < 0xa0;
    if (in_two) ++i;

    const bool stays = byte(i) == '\n' && keeps_line_breaks;
    if (in_two || byte(i) == 0x7f || (byte(i) < ' ' && !stays)) {
      shown += fmt::format("\\x{:02x}", byte(i));
    } else {
      shown += text[i];
    }
  }

  return shown;
}

}  // namespace

std::string printable(std::string_view text) {
  return without_controls(text, false);
}

std::string printable_lines(std::string_view text) {
  return without_controls(text, true);
}

std::string counted(std::size_t count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string with_names(std::string_view text,
                       std::optional<std::string> (*named)(std::string_view quoted)) {
  std::string shown;

  while (!text.empty()) {
    // 1. Copy the text up to the next backquote.
    const std::size_t begin = std::min(text.find('`'), text.size());
    shown += text.substr(0, begin);
    text.remove_prefix(begin);
    if (text.empty()) break;

    // 2. Replace the text between this backquote and the next if it names something. Otherwise copy
    // only this backquote: the next one may begin a name.
    const std::size_t end = text.find('`', 1);
    const auto name = end == text.npos ? std::nullopt : named(text.substr(1, end - 1));
    shown += name.value_or("`");
    text.remove_prefix(name ? end + 1 : 1);
  }

  return shown;
}

}  // namespace slipstream
