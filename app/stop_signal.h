#pragma once

#include <chrono>
#include <csignal>
#include <optional>

namespace slipstream::app {

/// To be called once, first: standard streams that are closed take nothing and no file gets their
/// numbers; SIGINT, SIGTERM and SIGHUP remove half-written files before they end the program; a
/// reader that is gone and a file that may not grow are failures to write, not signals; an
/// exception that nothing caught is a failure in one line.
void prepare_process();

/// While it lives the first SIGINT, SIGTERM or SIGHUP does not end the program but is remembered,
/// so that files can be finished; a second one ends it. There is one at a time.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  [[nodiscard]] bool raised() const;
  /// Forgets it, and remembers the next.
  void forget() const;
};

/// Whether the last StopSignal was raised by SIGHUP, and that is not forgotten.
bool hung_up();

/// Throws Error unless --duration is above 0 s, where it is given.
void require_duration(const std::optional<double>& duration);

/// The end of a run that would go on for ever: by a signal, or once it has lasted for `duration` s.
class RunEnd {
 public:
  explicit RunEnd(std::optional<double> duration) : duration_(duration) {}

  [[nodiscard]] bool reached() const;
  /// As if no signal had come.
  void forget_signal() const { stop_.forget(); }
  /// Since it was made.
  [[nodiscard]] double seconds() const;

 private:
  StopSignal stop_;
  std::optional<double> duration_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace slipstream::app
