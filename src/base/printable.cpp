#include "base/printable.h"

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

}  // namespace slipstream
