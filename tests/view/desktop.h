#pragma once

#include <array>
#include <csignal>
#include <optional>
#include <stdexcept>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

#include "tests/base/variable.h"

namespace slipstream {

/// An Xvfb display for the lifetime of this object.
class Desktop {
 public:
  /// `pixels`: existing folder in which Xvfb keeps the screen's pixels, in Xvfb_screen0; optional.
  explicit Desktop(const std::string& pixels = "") {
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) throw std::runtime_error("no pipe to Xvfb");
    server_ = ::fork();
    if (server_ == 0) {
      const std::string end = std::to_string(ends[1]);
      const char* const option = pixels.empty() ? nullptr : "-fbdir";
      // Without -noreset it refuses connections for a moment after its last client has gone.
      ::execlp("Xvfb", "Xvfb", "-noreset", "-displayfd", end.c_str(), "-screen", "0", "1280x800x24",
               option, pixels.c_str(), static_cast<char*>(nullptr));
      ::_exit(127);
    }
    ::close(ends[1]);
    std::string number;
    char letter = 0;
    while (::read(ends[0], &letter, 1) == 1 && letter != '\n') number += letter;
    ::close(ends[0]);
    if (number.empty()) throw std::runtime_error("Xvfb does not start; is it installed?");
    display_.emplace("DISPLAY", ":" + number);
  }
  /// Ends the Xvfb display as a crash of its server would.
  void crash() const { ::kill(server_, SIGKILL); }
  Desktop(const Desktop&) = delete;
  Desktop& operator=(const Desktop&) = delete;
  ~Desktop() {
    ::kill(server_, SIGTERM);
    ::waitpid(server_, nullptr, 0);
  }

 private:
  pid_t server_ = -1;
  std::optional<Variable> display_;
};

}  // namespace slipstream
