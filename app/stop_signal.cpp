#include "app/stop_signal.h"

#include <atomic>
#include <cmath>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream::app {
namespace {

// A signal handler reaches nothing else, and other threads than the one it ran in ask for it.
std::atomic<bool> stop_raised = false;
static_assert(std::atomic<bool>::is_always_lock_free);

/// The next signal ends the program, whichever of the two it is.
void raise_stop(int) {
  stop_raised = true;
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace

StopSignal::StopSignal() {
  stop_raised = false;
  struct sigaction action {};
  action.sa_handler = raise_stop;
  action.sa_flags = SA_RESTART;
  ::sigemptyset(&action.sa_mask);
  ::sigaction(SIGINT, &action, &interrupt_);
  ::sigaction(SIGTERM, &action, &terminate_);
}

StopSignal::~StopSignal() {
  ::sigaction(SIGINT, &interrupt_, nullptr);
  ::sigaction(SIGTERM, &terminate_, nullptr);
}

bool StopSignal::raised() const {
  return stop_raised;
}

void require_duration(const std::optional<double>& duration) {
  if (!duration || (*duration > 0 && std::isfinite(*duration))) return;
  throw Error(fmt::format("--duration {} is out of range; above 0 s", *duration));
}

bool RunEnd::reached() const {
  return stop_.raised() || (duration_ && seconds() >= *duration_);
}

double RunEnd::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

}  // namespace slipstream::app
