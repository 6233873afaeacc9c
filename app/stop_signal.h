#pragma once

#include <csignal>

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

}  // namespace slipstream::app
