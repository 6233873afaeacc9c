#include "app/output.h"

#include <string>

#include "slipstream/base/error.h"

namespace slipstream::app {
namespace {

/// The words of files and their names may hold characters that a terminal would obey: those of
/// ASCII, and U+0080 to U+009F.
std::string printable(std::string_view text) {
  std::string shown;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(text[at]); };
    const bool in_two = byte(i) == 0xc2 && i + 1 < text.size() && byte(i + 1) < 0xa0;
    if (in_two) ++i;
    if (in_two || byte(i) == 0x7f || (byte(i) < ' ' && byte(i) != '\n')) {
      shown += fmt::format("\\x{:02x}", byte(i));
    } else {
      shown += text[i];
    }
  }
  return shown;
}

}  // namespace

void Output::warn(std::string_view message) {
  write_line(stderr, fmt::format("warning: {}", message));
}

void Output::tell_failure(std::string_view message) {
  write_line(stderr, fmt::format("slipstream: {}", message));
}

void Output::finish() {
  if (json_) {  // names of files need not be UTF-8
    write_line(stdout, document.dump(2, ' ', true, nlohmann::json::error_handler_t::replace));
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw WorldError("cannot write to standard output");
}

void Output::release(const Output& held) {
  for (const auto& [stream, line] : held.held_) write_line(stream, line);
}

void Output::write_line(std::FILE* stream, std::string_view line) {
  if (holds_) return static_cast<void>(held_.emplace_back(stream, line));
  // finish() tells whether stdout took it; stderr has nobody to tell.
  const std::string shown = printable(line) + '\n';
  std::fwrite(shown.data(), 1, shown.size(), stream);
}

}  // namespace slipstream::app
