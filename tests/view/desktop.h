#pragma once

#include <array>
#include <csignal>
#include <cstdlib>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

namespace slipstream {

/// The existing desktop, or an Xvfb display for the lifetime of this object, if installed.
class Desktop {
 public:
  /// `pixels`: existing folder in which Xvfb keeps the screen's pixels, in Xvfb_screen0; optional.
  explicit Desktop(const std::string& pixels = "") {
    if (std::getenv("DISPLAY") != nullptr) return;
    std::array<int, 2> ends{};
    if (::pipe(ends.data()) != 0) return;
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
    if (!number.empty()) ::setenv("DISPLAY", (":" + number).c_str(), 1);
  }
  /// Ends the Xvfb display as a crash of its server would.
  void crash() const {
    if (server_ > 0) ::kill(server_, SIGKILL);
  }
  Desktop(const Desktop&) = delete;
  Desktop& operator=(const Desktop&) = delete;
  ~Desktop() {
    if (server_ <= 0) return;
    ::kill(server_, SIGTERM);
    ::waitpid(server_, nullptr, 0);
    ::unsetenv("DISPLAY");
  }

 private:
  pid_t server_ = -1;
};

}  // namespace slipstream
