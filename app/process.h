#pragma once

#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <utility>

namespace slipstream::app {

/// To be called once, first: standard streams that are closed take nothing and no file gets their
/// numbers; SIGINT, SIGTERM and SIGHUP remove half-written files before they end the program; a
/// reader that is gone and a file that may not grow are failures to write, not signals; an
/// exception that nothing caught is a failure in one line.
void prepare_process();

/// Memory of one scan serves the next: what goes back to the system comes again page by page,
/// zeroed, which costs more than reconstructing. Large pages make that cheaper the first time.
void keep_memory();

/// Tells systemd, where it started the program and wants to know: "READY=1", "STATUS=...".
void tell_service_manager(const std::string& state);

/// Throws Error unless --duration is above 0 s, where it is given.
void require_duration(const std::optional<double>& duration);

/// The end of a run that would go on for ever: by a signal, or once it has lasted for `duration` s.
/// While it lives the first SIGINT, SIGTERM or SIGHUP does not end the program but is remembered,
/// so that files can be finished; a second one ends it. There is one at a time.
class RunEnd {
 public:
  explicit RunEnd(std::optional<double> duration);
  ~RunEnd();
  RunEnd(const RunEnd&) = delete;
  RunEnd& operator=(const RunEnd&) = delete;

  [[nodiscard]] bool reached() const;
  /// As if no signal had come.
  void forget_signal() const;
  /// Since it was made.
  [[nodiscard]] double seconds() const;

 private:
  std::optional<double> duration_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Whether the last RunEnd was reached by SIGHUP, and that is not forgotten.
bool hung_up();

class Stopwatch {
 public:
  /// Seconds since it was made or last asked.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    return std::chrono::duration<double>(now - std::exchange(start_, now)).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace slipstream::app
