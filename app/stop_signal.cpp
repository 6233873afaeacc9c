#include "app/stop_signal.h"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include "slipstream/base/error.h"
#include "slipstream/io/file.h"

namespace slipstream::app {
namespace {

// A signal handler reaches nothing else, and other threads than the one it ran in ask for it.
std::atomic<int> stop_raised = 0;  // which signal it was
static_assert(std::atomic<int>::is_always_lock_free);

/// What nohup has the program ignore stays ignored.
void handle_ends(void (*handler)(int)) {
  struct sigaction action {
  }, before{};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    ::sigaction(signal, nullptr, &before);
    if (signal != SIGHUP || before.sa_handler != SIG_IGN) ::sigaction(signal, &action, nullptr);
  }
}

void end_program(int signal) {
  remove_temporary_files();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// What a destructor throws ends here, as where one of JSON gets no memory, and so does an
/// exception that nothing caught.
[[noreturn]] void end_by_exception() {
  remove_temporary_files();
  const char* why = "ended by an error that nothing handles";
  try {
    if (const auto failure = std::current_exception()) std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    why = "not enough memory";
  } catch (...) {
  }
  std::fprintf(stderr, "slipstream: %s\n", why);
  std::_Exit(1);
}

/// The next signal ends the program, whichever it is.
void raise_stop(int signal) {
  stop_raised = signal;
  handle_ends(end_program);
}

}  // namespace

void prepare_process() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    // The lowest number that is free is this one's.
    [[maybe_unused]] const int opened =
        ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  handle_ends(end_program);
  std::set_terminate(end_by_exception);
}

StopSignal::StopSignal() {
  forget();
}

StopSignal::~StopSignal() {
  handle_ends(end_program);
}

void StopSignal::forget() const {
  stop_raised = 0;
  handle_ends(raise_stop);
}

bool StopSignal::raised() const {
  return stop_raised != 0;
}

bool hung_up() {
  return stop_raised == SIGHUP;
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
