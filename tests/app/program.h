#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <sys/types.h>

#include "tests/io/temporary_folder.h"

namespace slipstream {

/// The program while it runs, stdin empty. It is killed if nobody waited for it.
class RunningProgram {
 public:
  /// `largest_file`: bytes that any file of it may grow to, as on a full disk; none where negative.
  explicit RunningProgram(const std::vector<std::string>& arguments, long largest_file = -1);
  RunningProgram(RunningProgram&& other) noexcept;
  RunningProgram& operator=(RunningProgram&&) = delete;
  ~RunningProgram();

  [[nodiscard]] pid_t process() const { return process_; }
  void send(int signal) const;
  /// Its exit code, or what signal ended it, negative.
  int wait();
  /// The most that it had at once, until it was waited for, bytes.
  [[nodiscard]] long memory() const { return memory_; }
  /// What it said until now.
  [[nodiscard]] std::string out() const;
  [[nodiscard]] std::string err() const;
  /// Both.
  [[nodiscard]] std::string words() const;
  [[nodiscard]] bool wait_for_words(const std::string& wanted) const;

 private:
  std::unique_ptr<TemporaryFolder> folder_ = std::make_unique<TemporaryFolder>();
  pid_t process_ = -1;
  long memory_ = 0;
};

/// What a run of the program left.
struct ProgramRun {
  int exit_code = -1;  ///< or what signal ended it, negative
  std::string out;
  std::string err;
};

ProgramRun run_program(const std::vector<std::string>& arguments, long largest_file = -1);

/// Fills `folder` with what `simulate` makes with these flags, which it makes once for all tests of
/// a process.
void copy_simulated_scan(const std::vector<std::string>& flags,
                         const std::filesystem::path& folder);

/// Waits for it, a minute at most. Returns whether it came.
bool wait_until(const std::function<bool()>& come);

std::string contents(const std::filesystem::path& path);

}  // namespace slipstream
