#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

#include "io/file.h"
#include "tests/io/temporary_folder.h"

namespace slipstream {

/// A running program with empty stdin. The destructor kills it unless wait() was called.
class RunningProgram {
 public:
  /// `largest_file`: limit on each file it writes, bytes, to simulate a full disk; negative: none.
  /// `descriptors`: limit on open files, with the three standard streams; negative: none.
  explicit RunningProgram(const std::vector<std::string>& arguments, long largest_file = -1,
                          int descriptors = -1);
  RunningProgram(RunningProgram&& other) noexcept;
  RunningProgram& operator=(RunningProgram&&) = delete;
  ~RunningProgram();

  [[nodiscard]] pid_t process() const { return process_; }
  void send(int signal) const;
  /// Returns its exit code, or minus the signal that ended it.
  int wait();
  /// Peak memory, bytes; valid after wait().
  [[nodiscard]] long memory() const { return memory_; }
  /// Output so far.
  [[nodiscard]] std::string out() const;
  [[nodiscard]] std::string err() const;
  /// stdout and stderr so far.
  [[nodiscard]] std::string words() const;
  [[nodiscard]] bool wait_for_words(const std::string& wanted) const;

 private:
  std::unique_ptr<TemporaryFolder> folder_ = std::make_unique<TemporaryFolder>();
  pid_t process_ = -1;
  long memory_ = 0;
};

/// Result of a finished run.
struct ProgramRun {
  int exit_code = -1;  ///< or minus the signal that ended it
  std::string out;
  std::string err;
};

ProgramRun run_program(const std::vector<std::string>& arguments, long largest_file = -1,
                       int descriptors = -1);

/// Copies a scan simulated with these flags to `folder`. Each set of flags is simulated once per
/// process.
void copy_simulated_scan(const std::vector<std::string>& flags,
                         const std::filesystem::path& folder);

/// Waits up to a minute until `come` returns true; returns false on timeout.
bool wait_until(const std::function<bool()>& come);

std::string contents(const std::filesystem::path& path);

}  // namespace slipstream
