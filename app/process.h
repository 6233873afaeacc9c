#pragma once

#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <utility>

namespace slipstream::app {

/// Call once, before anything but reload_at_hangup. Closed standard streams go to /dev/null, so
/// that no file gets their numbers; SIGINT, SIGTERM and SIGHUP remove half-written files before
/// they end the program; a closed pipe or a file size limit is a write error, not a signal; an
/// uncaught exception prints one line. stdout is flushed after each line.
void prepare_process();

/// Ends the program as SIGPIPE would, without half-written files; during a run, see RunEnd, ends
/// the run instead. Does nothing if SIGPIPE was ignored at the start, as under systemd.
void end_by_closed_pipe();

/// Keeps freed memory for the next scan: getting it back from the system page by page, zeroed,
/// costs more than reconstructing. Large pages make the first time cheaper.
void keep_memory();

/// Returns freed pictures to the system at once. Otherwise glibc keeps those of each thread, e.g. a
/// third of an ended recording's queue.
void return_memory();

/// Notifies systemd, if it started the program as a notify service: "READY=1", "STATUS=...".
void tell_service_manager(const std::string& state);

/// Throws Error if --duration is given and not above 0 s.
void require_duration(const std::optional<double>& duration);

/// From now on SIGHUP asks for a reload and never ends the program or a run. With nohup it stays
/// ignored.
void reload_at_hangup();

/// Whether SIGHUP has asked for a reload since the last call.
bool take_reload_request();

/// Decides when an endless run ends: by a signal or after `duration` s. While it exists the first
/// SIGINT, SIGTERM or SIGHUP (see reload_at_hangup) is remembered instead of ending the program, so
/// that files can be completed; a second one ends it. One within another's lifetime shares its
/// signal.
class RunEnd {
 public:
  explicit RunEnd(std::optional<double> duration);
  ~RunEnd();
  RunEnd(const RunEnd&) = delete;
  RunEnd& operator=(const RunEnd&) = delete;

  [[nodiscard]] bool reached() const;

  /// Since construction.
  [[nodiscard]] double seconds() const;

 private:
  std::optional<double> duration_;
  bool is_outermost_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Whether a signal has come since the outermost RunEnd began.
bool stopped_by_signal();

}  // namespace slipstream::app
