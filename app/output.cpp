#include "app/output.h"

#include <string>
#include <utility>

#include <unistd.h>

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

Progress::Progress(std::string label, std::int64_t total)
    : label_(std::move(label)), total_(total), terminal_(::isatty(STDERR_FILENO) == 1) {}

void Progress::finish() {
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

void Progress::advance(bool already) {
  ++done_;
  if (already) ++done_before_;
  const auto patience = std::chrono::seconds(1);
  if (!terminal_ || done_ == done_before_ || std::chrono::steady_clock::now() - start_ < patience)
    return;
  drawn_ = true;
  draw();
}

void Progress::draw() const {
  constexpr int width = 30;
  const auto filled =
      static_cast<int>(width * static_cast<double>(done_) / static_cast<double>(total_));
  const std::chrono::duration<double> past = std::chrono::steady_clock::now() - start_;
  const double rate = static_cast<double>(done_ - done_before_) / past.count();
  fmt::print(stderr, "\r{} [{:#<{}}{:.<{}}] {}/{}, {:.3g}/s, {:.0f} s left\033[K", label_, "",
             filled, "", width - filled, done_, total_, rate,
             static_cast<double>(total_ - done_) / rate);
  std::fflush(stderr);
}

}  // namespace slipstream::app
