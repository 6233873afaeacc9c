#include "app/progress.h"

#include <cstdio>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

namespace slipstream::app {

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
