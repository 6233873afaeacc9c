#include "app/process.h"

#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <new>
#include <string_view>

#include <fcntl.h>
#include <fmt/format.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "io/file.h"
#include "slipstream/error.h"

namespace slipstream::app {
namespace {

// Global, as a signal handler reaches nothing else; read from other threads too.
std::atomic<int> stop_raised = 0;  // the signal received
static_assert(std::atomic<int>::is_always_lock_free);
std::atomic<bool> reload_requested = false;
static_assert(std::atomic<bool>::is_always_lock_free);
std::atomic<bool> in_run = false;  // a RunEnd exists
bool ends_by_pipe = false;         // unless SIGPIPE was ignored from the start

void request_reload(int /*signal*/) {
  reload_requested = true;
}

/// SIGHUP stays ignored with nohup, and once it asks for reloads it does nothing else.
void handle(std::initializer_list<int> signals, void (*handler)(int)) {
  struct sigaction action {
  }, before{};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART;

  for (const int signal : signals) {
    ::sigaction(signal, nullptr, &before);
    const bool stays = before.sa_handler == SIG_IGN || before.sa_handler == request_reload;
    if (signal != SIGHUP || !stays) ::sigaction(signal, &action, nullptr);
  }
}

void handle_ends(void (*handler)(int)) {
  handle({SIGINT, SIGTERM, SIGHUP}, handler);
}

void end_program(int signal) {
  remove_temporary_files();

  // A closed pipe must end in silence. On a terminal the words replace a line that shows a wait.
  const auto write = [](std::string_view text) {
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
  };
  if (signal != SIGPIPE) {
    if (::isatty(STDERR_FILENO) == 1) write("\033[K");
    write("slipstream: stopped\n");
  }

  // As the signal would have ended it, so that the parent process sees why.
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

/// Reached by exceptions in destructors, e.g. of JSON without memory, and by uncaught exceptions.
[[noreturn]] void end_by_exception() {
  remove_temporary_files();
  const char* why = "ended by an unhandled error";
  try {
    if (const auto failure = std::current_exception()) std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    why = "not enough memory";
  } catch (...) {
  }

  // Not exit(), which would run destructors and could fail again.
  std::fprintf(stderr, "slipstream: %s\n", why);
  std::_Exit(1);
}

/// The next signal of any kind ends the program.
void raise_stop(int signal) {
  stop_raised = signal;
  handle_ends(end_program);
}

}  // namespace

void prepare_process() {
  // A closed stream is opened in the wrong direction, so that its use fails instead of being lost.
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    // open() returns the lowest free descriptor: this one.
    [[maybe_unused]] const int opened =
        ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
  }

  std::signal(SIGXFSZ, SIG_IGN);
  ends_by_pipe = std::signal(SIGPIPE, SIG_IGN) != SIG_IGN;

  // A reader of the pipe sees each line at once.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);

  handle_ends(end_program);
  std::set_terminate(end_by_exception);
}

void keep_memory() {
  constexpr int most = 32 << 20;  // larger values are refused
  constexpr std::uintptr_t page = 2 << 20;

  // Large blocks come from the heap and stay there when freed.
  ::mallopt(M_MMAP_THRESHOLD, most);
  ::mallopt(M_TRIM_THRESHOLD, 16 * most);
  ::mallopt(M_TOP_PAD, 4 * most);
  ::mallopt(M_ARENA_MAX, 1);  // memory freed by one thread serves another

  // Large pages for the free heap: a first large block makes the heap grow, then is freed.
  void* const first = std::malloc(most / 2);
  const auto begin = (reinterpret_cast<std::uintptr_t>(first) + page - 1) / page * page,
             end = reinterpret_cast<std::uintptr_t>(::sbrk(0)) / page * page;

  if (first != nullptr && begin < end) {
    ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
  }

  std::free(first);
}

void return_memory() {
  ::mallopt(M_MMAP_THRESHOLD, 256 << 10);  // setting it also keeps it from growing
}

void end_by_closed_pipe() {
  if (!ends_by_pipe) return;
  if (!in_run) end_program(SIGPIPE);
  stop_raised = SIGPIPE;
}

RunEnd::RunEnd(std::optional<double> duration)
    : duration_(duration), is_outermost_(!in_run.exchange(true)) {
  if (!is_outermost_) return;
  stop_raised = 0;
  handle_ends(raise_stop);
}

RunEnd::~RunEnd() {
  if (!is_outermost_) return;
  in_run = false;
  handle_ends(end_program);
}

void tell_service_manager(const std::string& state) {
  const char* const named = std::getenv("NOTIFY_SOCKET");
  sockaddr_un address{};

  const std::string path = named == nullptr ? "" : named;
  if (path.size() < 2 || path.size() > sizeof address.sun_path) return;

  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  if (path.front() == '@') address.sun_path[0] = '\0';  // not a file name

  const int descriptor = ::socket(AF_UNIX, SOCK_DGRAM, 0);
  if (descriptor < 0) return;
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());

  // Only the service manager listens; failures are ignored.
  static_cast<void>(::sendto(descriptor, state.data(), state.size(), 0,
                             reinterpret_cast<const sockaddr*>(&address), length));
  ::close(descriptor);
}

void reload_at_hangup() {
  handle({SIGHUP}, request_reload);
}

bool take_reload_request() {
  return reload_requested.exchange(false);
}

bool stopped_by_signal() {
  return stop_raised != 0;
}

void require_duration(const std::optional<double>& duration) {
  const double seconds = duration.value_or(1);
  require_in_range(seconds > 0 && std::isfinite(seconds), "--duration", seconds, "above 0 s");
}

bool RunEnd::reached() const {
  return stop_raised != 0 || (duration_ && seconds() >= *duration_);
}

double RunEnd::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

}  // namespace slipstream::app
