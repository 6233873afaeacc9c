#include "app/stop_signal.h"

namespace slipstream::app {
namespace {

// A signal handler reaches nothing else.
volatile std::sig_atomic_t stop_raised = 0;

void raise_stop(int) {
  stop_raised = 1;
}

}  // namespace

StopSignal::StopSignal() {
  stop_raised = 0;
  struct sigaction action {};
  action.sa_handler = raise_stop;
  action.sa_flags = SA_RESETHAND | SA_RESTART;
  ::sigemptyset(&action.sa_mask);
  ::sigaction(SIGINT, &action, &interrupt_);
  ::sigaction(SIGTERM, &action, &terminate_);
}

StopSignal::~StopSignal() {
  ::sigaction(SIGINT, &interrupt_, nullptr);
  ::sigaction(SIGTERM, &terminate_, nullptr);
}

bool StopSignal::raised() const {
  return stop_raised != 0;
}

}  // namespace slipstream::app
