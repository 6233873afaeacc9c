#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include <sys/types.h>

namespace slipstream {

/// What fails of the world's.
enum FaultCall : std::uint64_t {
  of_malloc,
  of_open,
  of_write,
  of_close,
  of_rename,
  of_fsync,
  of_thread,
  fault_calls
};

/// A place in the code that asks for memory is so many of its innermost frames, three of them here.
constexpr int frames_of_place = 7;
constexpr std::size_t most_places = 1 << 20;

/// What the program is asked for through the pipe `requests` in the folder SLIPSTREAM_FAULTS_FROM:
/// to run once with that call failing, from 1; with none, 0. It answers by `answers` with how the
/// run ended, as waitpid tells.
struct FaultRequest {
  FaultCall call{};
  std::uint64_t at = 0;
};

/// What a run did to a file, and how many bytes of it were written.
struct FileEvent {
  FaultCall call;
  int descriptor;
  std::uint64_t bytes;
};
constexpr std::size_t most_events = 1 << 16;

/// The file `record` in that folder, zeros before the run.
struct FaultRecord {
  std::atomic<std::uint64_t> faults;  ///< made
  std::uint64_t place;                ///< of the call that failed
  std::atomic<pid_t> process;
  std::atomic<std::uint64_t> calls[fault_calls];
  std::uint64_t places[most_places];  ///< of each call of malloc, where none is to fail
  std::atomic<std::uint64_t> events_made;
  FileEvent events[most_events];  ///< writes, renames and syncs that were done, in their order
};

}  // namespace slipstream
