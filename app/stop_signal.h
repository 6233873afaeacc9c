#pragma once

#include <chrono>
#include <csignal>
#include <optional>

namespace slipstream::app {

/// While it lives the first SIGINT or SIGTERM does not end the program but is remembered, so that
/// files can be finished; a second one ends it. There is one at a time.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  [[nodiscard]] bool raised() const;

 private:
  struct sigaction interrupt_ {};
  struct sigaction terminate_ {};
};

/// Throws Error unless --duration is above 0 s, where it is given.
void require_duration(const std::optional<double>& duration);

/// The end of a run that would go on for ever: by a signal, or once it has lasted for `duration` s.
class RunEnd {
 public:
  explicit RunEnd(std::optional<double> duration) : duration_(duration) {}

  [[nodiscard]] bool reached() const;
  /// Since it was made.
  [[nodiscard]] double seconds() const;

 private:
  StopSignal stop_;
  std::optional<double> duration_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace slipstream::app
